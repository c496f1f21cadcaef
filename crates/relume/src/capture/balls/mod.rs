//! Lights from mirror balls: a glossy ball photographed beside the surface shows where each lamp was.
//!
//! A mirror of normal N reflects the light of direction L towards the viewer V where
//!
//! L = 2 (N . V) N - V,
//!
//! and the normal of a ball at a pixel is known from its outline. The camera is taken to be far away and straight
//! above (V = z). One ball gives directions; where two or more balls see the lamps from noticeably different sides,
//! their rays also give positions.
//!
//! The method is the usual one of reflectance transformation imaging (M. Mudge, T. Malzbender, C. Schroer, M. Lum, New
//! reflection transformation imaging methods for rock art and multiple-viewpoint display, VAST 2006).
//!
//! | file | content |
//! |---|---|
//! | `outline` | edges with their directions, to a fraction of a pixel |
//! | `circles` | balls in photographs: circles in which lines across edges meet (Hough) |
//! | `highlight` | the place of the highlight in a ball |
//! | `rays` | the position of a lamp from the rays of several balls |
//! | `drawing` | a picture of what was found |

mod circles;
mod drawing;
mod highlight;
mod outline;
mod rays;

pub use drawing::drawn;
pub use highlight::{Highlight, NoHighlight};

use serde::Serialize;

use crate::direction::Direction;
use crate::error::{Error, Result};
use crate::job::Job;
use crate::parallel;
use crate::planes::Planes;
use crate::raster::LoadRaster;
use crate::size::Size;
use crate::space::Space;
use crate::words::listed;
use circles::Circle;

/// The outline of a mirror ball in photographs, in pixels from their upper left corner, y downwards; the middle of
/// the first pixel is (0.5, 0.5).
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct MirrorBall {
    /// The column of the centre.
    pub x: f64,
    /// The row of the centre.
    pub y: f64,
    /// The radius.
    pub radius: f64,
}

/// The share of photographs in which a circle that was found must show a highlight to be taken for a ball.
const LEAST_LIT: f64 = 0.7;
/// The least motion of the highlights in a ball, as a fraction of its radius: others are reflections of the room.
const LEAST_MOTION: f64 = 0.02;
/// Balls whose directions differ by more than this for half of the lamps are not balls: near lamps make 10 degrees.
const MOST_APART_RAD: f64 = 25.0 * std::f64::consts::PI / 180.0;
/// Highlights farther from the centre than this, in radii, are of lamps below the surface.
const HORIZON: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// What one photograph says of its lamp.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BallFrame {
    /// The name of the photograph.
    pub name: String,
    /// The highlight in each ball, in their order; `None` where there is none.
    pub highlights: Vec<Option<Highlight>>,
    /// The unit vector towards the lamp; `None` without a highlight.
    pub direction: Option<[f64; 3]>,
    /// The lamp in pixels from the middle of the picture, x right, y up, z from the plane on which the balls lie;
    /// `None` where it is too far away for the balls to tell.
    pub position: Option<[f64; 3]>,
    /// Why there is no direction, in words.
    pub problem: Option<String>,
}

/// The lamps of all photographs.
#[derive(Debug, Clone, PartialEq)]
pub struct BallLights {
    /// The balls used.
    pub balls: Vec<MirrorBall>,
    /// One entry for each photograph, in their order.
    pub frames: Vec<BallFrame>,
    /// The largest angle between the directions that two balls give for one lamp, in degrees.
    pub disagreement_deg: Option<f64>,
    /// The size of the photographs.
    pub size: Size,
}

impl BallLights {
    /// The directions of the photographs that have one, by name.
    pub fn lights(&self) -> Vec<(String, Direction)> {
        let known = |frame: &BallFrame| {
            let [x, y, z] = frame.direction?;
            Some((frame.name.clone(), Direction::new(x, y, z).ok()?))
        };
        self.frames.iter().filter_map(known).collect()
    }

    /// Refuses photographs without a direction, and names them.
    ///
    /// # Errors
    /// When there are some.
    pub fn refuse_problems(&self) -> Result<()> {
        let problems: Vec<String> = self.frames.iter().filter_map(BallFrame::trouble).collect();
        match problems.len() {
            0 => Ok(()),
            n if n == self.frames.len() => Err(Error::invalid(format!(
                "none of the {n} photographs shows a lamp ({}): give the outline of a mirror ball as --ball X,Y,R",
                problems[0]
            ))),
            n => Err(Error::invalid(format!(
                "{n} of {} photographs show no usable lamp: {}",
                self.frames.len(),
                listed(&problems, 4, ", ")
            ))),
        }
    }
}

impl BallFrame {
    /// The photograph and its problem.
    pub fn trouble(&self) -> Option<String> {
        self.problem.as_ref().map(|problem| format!("{} {problem}", self.name))
    }
}

/// Finds the balls in photographs, and measures what they show.
///
/// `names` are those of the photographs, and `load(i)` reads the i-th; each is read twice.
///
/// # Errors
/// No photographs, photographs that differ in size, no ball, and errors of `load` and of the job.
pub fn find_lights(names: &[String], load: &LoadRaster, job: &Job) -> Result<BallLights> {
    let circles = circles::find(names, load, job)?;
    let size = load(0)?.size();
    let candidates = circles.iter().map(Circle::ball).filter(|ball| ball.check(size).is_ok());
    let candidates: Vec<MirrorBall> = candidates.collect();
    let none = || {
        Error::invalid(
            "no mirror ball was found, a round outline in which a highlight moves from photograph to photograph: give \
             its outline as --ball X,Y,R",
        )
    };
    if candidates.is_empty() {
        return Err(none());
    }
    let (size, seen) = highlights(names, load, &candidates, job)?;
    let lit: Vec<usize> = (0..candidates.len()).filter(|&k| is_lit(&seen, k, &candidates[k])).collect();
    let real = agreeing(&candidates, &seen, &lit);
    if real.is_empty() {
        return Err(none());
    }
    let balls: Vec<MirrorBall> = real.iter().map(|&k| candidates[k]).collect();
    let seen: Vec<_> = seen.iter().map(|frame| real.iter().map(|&k| frame[k]).collect()).collect();
    Ok(measured(names, balls, &seen, size))
}

/// Measures what given balls show.
///
/// # Errors
/// As [`find_lights`], a ball outside the photographs, and one given twice.
pub fn lights_of(names: &[String], load: &LoadRaster, balls: &[MirrorBall], job: &Job) -> Result<BallLights> {
    if let Some(i) = (1..balls.len()).find(|&i| balls[..i].contains(&balls[i])) {
        let MirrorBall { x, y, radius } = balls[i];
        return Err(Error::usage(format!(
            "the ball at ({x}, {y}) with radius {radius} is given twice: give each ball once, and others where they are"
        )));
    }
    let (size, seen) = highlights(names, load, balls, job)?;
    Ok(measured(names, balls.to_vec(), &seen, size))
}

/// What is seen in each ball of one photograph.
type SeenInBalls = Vec<Result<Highlight, NoHighlight>>;

/// Whether highlights are seen in a circle in most photographs, and move.
fn is_lit(seen: &[SeenInBalls], k: usize, ball: &MirrorBall) -> bool {
    let found: Vec<Highlight> = seen.iter().filter_map(|frame| frame[k].ok()).collect();
    let spread = |of: &dyn Fn(&Highlight) -> f64| {
        let mean = found.iter().map(of).sum::<f64>() / found.len() as f64;
        (found.iter().map(|h| (of(h) - mean).powi(2)).sum::<f64>() / found.len() as f64).sqrt()
    };
    let motion = spread(&|h| h.x).hypot(spread(&|h| h.y));
    found.len() as f64 >= LEAST_LIT * seen.len() as f64
        && (seen.len() < 2 || motion > LEAST_MOTION * ball.radius)
}

/// The largest group of candidates that show the lamps in about the same directions; the larger ball of equal groups.
fn agreeing(candidates: &[MirrorBall], seen: &[SeenInBalls], lit: &[usize]) -> Vec<usize> {
    let direction = |frame: &SeenInBalls, k: usize| Some(reflected(candidates[k].normal(frame[k].ok()?)));
    let agree = |a: usize, b: usize| {
        let apart = seen.iter().filter_map(|frame| Some(direction(frame, a)?.dot(direction(frame, b)?)));
        let mut cosines: Vec<f64> = apart.collect();
        if cosines.is_empty() {
            return false;
        }
        let middle = cosines.len() / 2;
        *cosines.select_nth_unstable_by(middle, f64::total_cmp).1 > MOST_APART_RAD.cos()
    };
    let group =
        |&a: &usize| -> Vec<usize> { lit.iter().copied().filter(|&b| a == b || agree(a, b)).collect() };
    let groups = lit.iter().map(|a| (group(a), candidates[*a].radius));
    let largest = groups.max_by(|a, b| a.0.len().cmp(&b.0.len()).then(a.1.total_cmp(&b.1)));
    largest.map_or(Vec::new(), |(group, _)| group)
}

/// The highlights of every ball in every photograph, and the size of the photographs.
fn highlights(
    names: &[String],
    load: &LoadRaster,
    balls: &[MirrorBall],
    job: &Job,
) -> Result<(Size, Vec<SeenInBalls>)> {
    if names.is_empty() {
        return Err(Error::usage("lights are found in photographs, and there are none"));
    }
    let size = load(0)?.size();
    for ball in balls {
        ball.check(size)?;
    }
    job.start("looking for highlights", names.len() as u64);
    let seen = parallel::try_map(names.iter().enumerate(), |(i, name)| {
        let photograph = load(i)?;
        if photograph.size() != size {
            return Err(Error::invalid(format!(
                "the photograph {name} is {} texels and {} is {size}: all must have the same size",
                photograph.size(),
                names[0]
            )));
        }
        let seen = balls.iter().map(|ball| {
            let (x, y, part) = ball.square(size);
            let square = photograph.crop(x, y, part)?.to_picture(Space::Linear);
            Ok(highlight::find(&luminance(&square.planes), (x, y), ball))
        });
        let seen = seen.collect::<Result<SeenInBalls>>()?;
        job.advance(1)?;
        Ok(seen)
    })?;
    Ok((size, seen))
}

/// The lamps of all photographs from what the balls show.
fn measured(names: &[String], balls: Vec<MirrorBall>, seen: &[SeenInBalls], size: Size) -> BallLights {
    let frames: Vec<BallFrame> =
        names.iter().zip(seen).map(|(name, seen)| frame(name, &balls, seen, size)).collect();
    let angles = frames.iter().filter_map(|frame| largest_angle(&directions(&balls, &frame.highlights)));
    let disagreement = angles.fold(None, |most: Option<f64>, a| Some(most.map_or(a, |most| most.max(a))));
    let mut lights = BallLights { balls, frames, disagreement_deg: disagreement.map(f64::to_degrees), size };
    // Either all lamps are near enough to be placed, or none is: directions are then of one kind.
    if lights.frames.iter().any(|frame| frame.direction.is_some() && frame.position.is_none()) {
        lights.frames.iter_mut().for_each(|frame| frame.position = None);
    }
    for frame in &mut lights.frames {
        if let Some([x, y, z]) = frame.position {
            frame.direction = Direction::new(x, y, z).ok().map(Direction::to_array);
        }
    }
    lights
}

fn frame(name: &str, balls: &[MirrorBall], seen: &SeenInBalls, size: Size) -> BallFrame {
    let highlights: Vec<Option<Highlight>> = seen.iter().map(|seen| seen.ok()).collect();
    let mut frame =
        BallFrame { name: name.to_owned(), direction: None, position: None, problem: None, highlights };
    let found = directions(balls, &frame.highlights);
    if found.is_empty() {
        let reason = seen.iter().find_map(|seen| seen.err()).unwrap_or(NoHighlight::Dark);
        frame.problem = Some(reason.to_string());
        return frame;
    }
    let sum = (0..3).map(|k| found.iter().map(|(_, d)| d.to_array()[k]).sum::<f64>()).collect::<Vec<_>>();
    match Direction::new(sum[0], sum[1], sum[2]) {
        Ok(mean) if mean.z() > 0.0 => {
            frame.direction = Some(mean.to_array());
            frame.position = rays::meet(&found, size);
        }
        _ => frame.problem = Some("shows its lamp below the surface".to_owned()),
    }
    frame
}

/// The direction that each ball with a highlight gives, with the place of the reflection.
fn directions(balls: &[MirrorBall], highlights: &[Option<Highlight>]) -> Vec<(rays::Reflection, Direction)> {
    let of = |(ball, highlight): (&MirrorBall, &Option<Highlight>)| {
        let normal = ball.normal((*highlight)?);
        Some((rays::Reflection::new(ball, normal), reflected(normal)))
    };
    balls.iter().zip(highlights).filter_map(of).collect()
}

/// The direction of the light that a mirror of this normal reflects straight up.
fn reflected(normal: [f64; 3]) -> Direction {
    let [x, y, z] = normal;
    Direction::new(2.0 * z * x, 2.0 * z * y, 2.0 * z * z - 1.0).expect("a reflection has the length 1")
}

fn largest_angle(found: &[(rays::Reflection, Direction)]) -> Option<f64> {
    let angle = |a: Direction, b: Direction| a.dot(b).clamp(-1.0, 1.0).acos();
    let pairs = found.iter().enumerate().flat_map(|(i, a)| found[..i].iter().map(move |b| angle(a.1, b.1)));
    pairs.max_by(f64::total_cmp)
}

impl MirrorBall {
    /// Refuses an outline that is not inside the photographs, or too small to measure in.
    fn check(&self, size: Size) -> Result<()> {
        let Self { x, y, radius } = *self;
        if !(radius >= 4.0 && x.is_finite() && y.is_finite()) {
            return Err(Error::usage(format!(
                "the ball at ({x}, {y}) has a radius of {radius} pixels: expected at least 4"
            )));
        }
        let inside = x >= 0.7 * radius
            && y >= 0.7 * radius
            && x + 0.7 * radius <= size.width as f64
            && y + 0.7 * radius <= size.height as f64;
        if !inside {
            return Err(Error::invalid(format!(
                "the ball at ({x:.1}, {y:.1}) with radius {radius:.1} is not inside the photographs of {size} pixels: give the \
                 column and row of its centre, counted from the upper left corner"
            )));
        }
        Ok(())
    }

    /// The square of pixels around it, as far as it is inside.
    fn square(&self, size: Size) -> (usize, usize, Size) {
        let low = |at: f64| (at - self.radius).floor().max(0.0) as usize;
        let high = |at: f64, most: usize| ((at + self.radius).ceil() as usize).min(most);
        let (x, y) = (low(self.x), low(self.y));
        (x, y, Size::new(high(self.x, size.width) - x, high(self.y, size.height) - y))
    }

    /// The unit normal of the ball where the highlight is; x right, y up.
    fn normal(&self, highlight: Highlight) -> [f64; 3] {
        let (x, y) = ((highlight.x - self.x) / self.radius, (self.y - highlight.y) / self.radius);
        [x, y, (1.0 - x * x - y * y).max(0.0).sqrt()]
    }
}

/// One plane of luminance (ITU-R BT.709) of one or three planes.
fn luminance(planes: &Planes) -> Planes {
    if planes.count() == 1 {
        return planes.clone();
    }
    let mut out = Planes::zeros(planes.size(), 1);
    for (texel, value) in out.plane_mut(0).iter_mut().enumerate() {
        let [r, g, b] = [0, 1, 2].map(|c| planes.plane(c)[texel]);
        *value = 0.2126 * r + 0.7152 * g + 0.0722 * b;
    }
    out
}

#[cfg(test)]
mod tests;
