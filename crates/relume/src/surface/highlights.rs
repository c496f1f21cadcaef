//! Roughness and the strength of highlights, from photographs under many lights and the normals.
//!
//! What a matt body leaves over of each texel is explained by one lobe of microfacets (`microfacet`: Walter et al. 2007,
//! Heitz 2014, Schlick 1994), after the separation of S. K. Nayar, K. Ikeuchi, T. Kanade, "Surface Reflection: Physical
//! and Geometrical Perspectives" (IEEE PAMI 13(7), 1991) and the fit for each texel of D. McAllister, A. Lastra, W.
//! Heidrich, "Efficient Rendering of Spatial Bi-directional Reflectance Distribution Functions" (Graphics Hardware
//! 2002). For one roughness, body and lobe are found by least squares with both not negative; the roughness is the one, between
//! a few, with the least residual, where a lobe of another strength than a dielectric's costs something. It is summed over a window because few texels face the half of a lamp's way.
//!
//! Values in shadow, at grazing light, and at white take no part. Limits: one camera straight above, far lamps of equal
//! strength, and a lobe that is no narrower than the lamps are apart; light between parts of the surface counts as body.
//! Metal is not told from a bright lobe on a dark body.

use super::luminance;
use super::photometric_stereo::StereoInput;
use crate::error::{Error, Result};
use crate::job::Job;
use crate::memory::Footprint;
use crate::microfacet::{DIELECTRIC_F0, alpha, specular};
use crate::parallel;
use crate::planes::Planes;
use crate::raster::RasterSequence;
use crate::size::Size;
use crate::space::Space;

/// The roughnesses that are compared; between them a parabola decides.
const ROUGHNESSES: [f64; 12] = [0.1, 0.15, 0.2, 0.27, 0.35, 0.43, 0.52, 0.61, 0.7, 0.8, 0.9, 1.0];
/// Fewer lights show no lobe.
pub const LEAST_LIGHTS: usize = 12;
/// The least cosine of a light that counts.
const LEAST_COSINE: f64 = 0.15;
/// A value below this share of the texel's usual brightness is a shadow.
const SHADOW: f64 = 0.3;
/// Linear values from this on are white whatever the surface does.
const WHITE: f64 = 0.99;
/// The weight of the expected strength of a lobe, that of a dielectric, relative to what the lights say of it. Without it
/// broad weak lobes explain light between parts of the surface, and every material comes out too glossy.
const EXPECTED_WEIGHT: f64 = 0.3;
/// A lobe explains something if it takes this share off the residual of the body alone.
const LEAST_GAIN: f64 = 0.1;

/// The residuals of all texels count in each window as those of its texels do under so many lights, and less with the square of
/// their number: few lights show few highlights, and windows without one would follow their noise.
const LEANING_LIGHTS: f64 = 8.0;

/// Options of the estimate.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
pub struct HighlightOptions {
    /// Texels from the middle of a window to its sides; 0 takes each texel alone.
    pub radius: usize,
}

impl Default for HighlightOptions {
    fn default() -> Self {
        Self { radius: 4 }
    }
}

/// The result.
#[derive(Debug, Clone, PartialEq)]
pub struct Highlights {
    /// Roughness, the square root of alpha, one plane.
    pub roughness: Planes,
    /// Reflectance at normal incidence; 0.04 of a dielectric of refractive index 1.5. One plane.
    pub reflectance: Planes,
    /// The roughness of all texels together.
    pub overall: f64,
    /// Whether a highlight is seen in the window of a texel: others have the roughness of all.
    pub seen: Vec<bool>,
}

/// One texel: the residual of the body alone, and of body and lobe for each roughness.
#[derive(Clone, Copy)]
struct TexelResiduals {
    matt: f32,
    with_lobe: [f32; ROUGHNESSES.len()],
}

impl TexelResiduals {
    const ZERO: Self = Self { matt: 0.0, with_lobe: [0.0; ROUGHNESSES.len()] };

    /// Those of a window with a share of those of all texels.
    fn leant_on(&self, overall: &Self, lights: usize) -> Self {
        let share = (LEANING_LIGHTS / lights as f64).powi(2) as f32;
        let scale = if overall.matt > 0.0 { share * self.matt / overall.matt } else { 0.0 };
        let with_lobe = std::array::from_fn(|k| self.with_lobe[k] + scale * overall.with_lobe[k]);
        Self { matt: self.matt, with_lobe }
    }
}

/// The memory of [`highlights()`] of `size` texels under so many lights, beside one photograph and the normals.
pub fn footprint(size: Size, lights: usize) -> Footprint {
    // Those of texels, of rows and of windows; two maps stay, and what is seen.
    let residuals = Footprint::of_texels(size, 3 * size_of::<TexelResiduals>() as u64, 9);
    Footprint { peak: values_bytes(size, lights).saturating_add(residuals.peak), ..residuals }
}

/// Refuses lights that show no lobe.
///
/// # Errors
/// Fewer than [`LEAST_LIGHTS`] lights, and lamps that are near.
pub fn check(lights: usize, are_near: bool) -> Result<()> {
    if lights < LEAST_LIGHTS {
        return Err(Error::invalid(format!(
            "roughness needs at least {LEAST_LIGHTS} lights, found {lights}"
        )));
    }
    if are_near {
        return Err(Error::usage("roughness is estimated under far lamps only: leave out --surface-mm"));
    }
    Ok(())
}

/// The bytes of the values of all photographs.
fn values_bytes(size: Size, lights: usize) -> u64 {
    Footprint::of_texels(size, 4 * lights as u64, 0).peak
}

/// Estimates both maps from photographs, in linear light, and unit normals.
///
/// # Errors
/// Fewer than [`LEAST_LIGHTS`] lights, lamps that are near, normals of another size, errors of `load`, and the limits.
pub fn highlights(
    input: StereoInput<'_>,
    normals: &Planes,
    options: HighlightOptions,
    job: &Job,
) -> Result<Highlights> {
    check(input.lights.len(), input.lamps.is_some())?;
    let lights: Vec<[f64; 3]> = input.lights.iter().map(|(_, light)| light.to_array()).collect();
    let size = normals.size();
    let needed = footprint(size, lights.len()).peak;
    job.check_bytes("the highlights", needed)?;
    let _values = job.hold("the highlights", values_bytes(size, lights.len()))?;
    let values = read(input, size, lights.len(), job)?;
    let _residuals = job.hold("the highlights", needed - values_bytes(size, lights.len()))?;
    let texel = |at: usize| Observed::new(&lights, normals, &values, at);
    job.proceed()?;
    let mut residuals = vec![TexelResiduals::ZERO; size.texels()];
    parallel::for_each_value(&mut residuals, |at, residuals| *residuals = texel(at).residuals());
    job.proceed()?;
    let overall = total(&residuals);
    let pooled = pooled(&residuals, size, options.radius);
    let whole = best(&overall.with_lobe).0;
    let chosen = |window: &TexelResiduals| {
        let (_, least) = best(&window.with_lobe);
        let (roughness, _) = best(&window.leant_on(&overall, lights.len()).with_lobe);
        let matt = f64::from(window.matt);
        (matt - least > LEAST_GAIN * matt).then_some(roughness)
    };
    let chosen: Vec<Option<f64>> = pooled.iter().map(chosen).collect();
    let roughness: Vec<f32> = chosen.iter().map(|seen| seen.unwrap_or(whole) as f32).collect();
    let mut reflectance = vec![0.0f32; size.texels()];
    parallel::for_each_value(&mut reflectance, |at, reflectance| {
        let (_, lobe) = texel(at).solved(alpha(f64::from(roughness[at])));
        *reflectance = (lobe * DIELECTRIC_F0).min(1.0) as f32;
    });
    Ok(Highlights {
        seen: chosen.iter().map(Option::is_some).collect(),
        roughness: Planes::from_vec(size, 1, roughness)?,
        reflectance: Planes::from_vec(size, 1, reflectance)?,
        overall: whole,
    })
}

/// The luminance of all photographs, texel after texel.
fn read(input: StereoInput<'_>, size: Size, count: usize, job: &Job) -> Result<Vec<f32>> {
    let photographs = RasterSequence::open(input.load)?;
    if photographs.size() != size {
        return Err(Error::usage(format!(
            "the normals have {size} texels, the photographs {}: they must be registered",
            photographs.size()
        )));
    }
    job.start("highlights", count as u64);
    let mut values = vec![0.0; count * size.texels()];
    for light in 0..count {
        let photograph = photographs.read(light)?;
        // Floats are not clipped.
        let clips = photograph.samples().space() == Space::Srgb;
        let planes = photograph.to_picture(Space::Linear).planes;
        let brightest = |at: usize| (0..planes.count()).map(|k| planes.plane(k)[at]).fold(0.0, f32::max);
        for (at, of_texel) in values.chunks_exact_mut(count).enumerate() {
            let is_white = clips && f64::from(brightest(at)) >= WHITE;
            of_texel[light] = if is_white { f32::NAN } else { luminance::of_texel(&planes, at) as f32 };
        }
        job.advance(1)?;
    }
    Ok(values)
}

/// What one texel shows: cosines and values of the lights that count.
struct Observed {
    /// The cosines at the light, between half vector and normal, and between light and half vector; and the value.
    lights: Vec<[f64; 4]>,
    /// The cosine at the viewer.
    n_v: f64,
}

impl Observed {
    fn new(lights: &[[f64; 3]], normals: &Planes, values: &[f32], at: usize) -> Self {
        let normal: [f64; 3] = std::array::from_fn(|k| f64::from(normals.plane(k)[at]));
        let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let values = &values[at * lights.len()..][..lights.len()];
        let mut seen: Vec<[f64; 4]> = lights
            .iter()
            .zip(values)
            .filter(|(light, value)| dot(**light, normal) > LEAST_COSINE && !value.is_nan())
            .map(|(light, value)| {
                let half = [light[0], light[1], light[2] + 1.0];
                let length = dot(half, half).sqrt();
                [
                    dot(*light, normal),
                    dot(half, normal) / length,
                    dot(half, *light) / length,
                    f64::from(*value),
                ]
            })
            .collect();
        let mut shading: Vec<f64> = seen.iter().map(|[n_l, .., value]| value / n_l).collect();
        shading.sort_by(f64::total_cmp);
        let usual = shading.get(shading.len() / 2).copied().unwrap_or(0.0);
        seen.retain(|[n_l, .., value]| *value > SHADOW * usual * n_l);
        Self { lights: seen, n_v: normal[2].max(0.05) }
    }

    /// The strengths of body and lobe of least squares, not negative; the lobe relative to that of a dielectric, which is
    /// expected.
    fn solved(&self, alpha: f64) -> (f64, f64) {
        let [mut bb, mut bl, mut ll, mut bv, mut lv] = [0.0; 5];
        for (body, lobe, value) in self.terms(alpha) {
            bb += body * body;
            bl += body * lobe;
            ll += lobe * lobe;
            bv += body * value;
            lv += lobe * value;
        }
        lv += EXPECTED_WEIGHT * ll;
        ll *= 1.0 + EXPECTED_WEIGHT;
        let determinant = bb * ll - bl * bl;
        let (body, lobe) = if determinant > 1e-9 * bb * ll {
            ((ll * bv - bl * lv) / determinant, (bb * lv - bl * bv) / determinant)
        } else {
            (f64::INFINITY, -1.0)
        };
        match (body >= 0.0, lobe >= 0.0) {
            (true, true) => (body, lobe),
            (false, _) => (0.0, (lv / ll.max(1e-12)).max(0.0)),
            (true, false) => ((bv / bb.max(1e-12)).max(0.0), 0.0),
        }
    }

    /// For each light what a white body and the lobe of a dielectric show, and the value.
    fn terms(&self, alpha: f64) -> impl Iterator<Item = (f64, f64, f64)> {
        self.lights.iter().map(move |&[n_l, n_h, l_h, value]| {
            (n_l, n_l * specular(n_l, self.n_v, n_h, l_h, alpha, DIELECTRIC_F0), value)
        })
    }

    fn residual(&self, alpha: f64, (body, lobe): (f64, f64)) -> f64 {
        let unexpected = EXPECTED_WEIGHT * (lobe - 1.0).powi(2);
        self.terms(alpha)
            .map(|(b, l, value)| (body * b + lobe * l - value).powi(2) + unexpected * l * l)
            .sum()
    }

    fn residuals(&self) -> TexelResiduals {
        if self.lights.len() < 4 {
            return TexelResiduals { matt: 0.0, with_lobe: [0.0; ROUGHNESSES.len()] };
        }
        let [bb, bv] = self
            .lights
            .iter()
            .fold([0.0; 2], |[bb, bv], [n_l, .., value]| [bb + n_l * n_l, bv + n_l * value]);
        let body = bv / bb;
        let matt: f64 = self.lights.iter().map(|[n_l, .., value]| (body * n_l - value).powi(2)).sum();
        let with = |roughness: f64| {
            let alpha = alpha(roughness);
            self.residual(alpha, self.solved(alpha)) as f32
        };
        TexelResiduals { matt: matt as f32, with_lobe: ROUGHNESSES.map(with) }
    }
}

fn total(residuals: &[TexelResiduals]) -> TexelResiduals {
    let sum =
        |of: &dyn Fn(&TexelResiduals) -> f32| residuals.iter().map(|r| f64::from(of(r))).sum::<f64>() as f32;
    TexelResiduals { matt: sum(&|r| r.matt), with_lobe: std::array::from_fn(|k| sum(&|r| r.with_lobe[k])) }
}

/// Sums over windows that end at the border: of rows, then of columns.
fn pooled(residuals: &[TexelResiduals], size: Size, radius: usize) -> Vec<TexelResiduals> {
    let window = |at: usize, length: usize| at.saturating_sub(radius)..(at + radius + 1).min(length);
    let mut along_rows = vec![TexelResiduals::ZERO; size.texels()];
    parallel::for_each_value(&mut along_rows, |at, sum| {
        let (x, y) = (at % size.width, at / size.width);
        *sum = total_of(window(x, size.width).map(|x| &residuals[size.index(x, y)]));
    });
    let mut pooled = vec![TexelResiduals::ZERO; size.texels()];
    parallel::for_each_value(&mut pooled, |at, sum| {
        let (x, y) = (at % size.width, at / size.width);
        *sum = total_of(window(y, size.height).map(|y| &along_rows[size.index(x, y)]));
    });
    pooled
}

fn total_of<'a>(some: impl Iterator<Item = &'a TexelResiduals>) -> TexelResiduals {
    let mut sum = TexelResiduals::ZERO;
    for one in some {
        sum.matt += one.matt;
        sum.with_lobe.iter_mut().zip(&one.with_lobe).for_each(|(sum, v)| *sum += v);
    }
    sum
}

/// The roughness of the least residual, by a parabola through the least and its neighbours, and that residual.
fn best(residuals: &[f32; ROUGHNESSES.len()]) -> (f64, f64) {
    let k = (0..residuals.len()).min_by(|a, b| residuals[*a].total_cmp(&residuals[*b])).unwrap_or(0);
    let value = |k: usize| f64::from(residuals[k]);
    if k == 0 || k + 1 == residuals.len() {
        return (ROUGHNESSES[k], value(k));
    }
    let [x0, x1, x2] = [k - 1, k, k + 1].map(|k| ROUGHNESSES[k]);
    let [d0, d2] = [(value(k - 1) - value(k)) / (x0 - x1), (value(k + 1) - value(k)) / (x2 - x1)];
    let curvature = (d2 - d0) / (x2 - x0);
    let lowest = if curvature > 0.0 { x1 - (d0 - curvature * (x0 - x1)) / (2.0 * curvature) } else { x1 };
    (lowest.clamp(x0, x2), value(k))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::direction::Direction;
    use crate::microfacet::body_share;
    use crate::raster::{Raster, Samples};

    /// Lights on rings, from straight above to 15 degrees above the horizon.
    fn lights() -> Vec<(String, Direction)> {
        let ring = |polar: f64, count: usize| {
            (0..count).map(move |i| {
                let (t, p) = (polar.to_radians(), std::f64::consts::TAU * i as f64 / count as f64);
                Direction::new(t.sin() * p.cos(), t.sin() * p.sin(), t.cos()).unwrap()
            })
        };
        let all = ring(0.0, 1)
            .chain(ring(20.0, 8))
            .chain(ring(40.0, 14))
            .chain(ring(60.0, 16))
            .chain(ring(75.0, 10));
        all.enumerate().map(|(i, light)| (i.to_string(), light)).collect()
    }

    /// A bumpy surface.
    fn normals(size: Size) -> Planes {
        let mut planes = Planes::zeros(size, 3);
        for at in 0..size.texels() {
            let (x, y) = ((at % size.width) as f64, (at / size.width) as f64);
            let (p, q) = (0.5 * (x * 0.35).sin(), 0.5 * (y * 0.45).cos());
            let length = (p * p + q * q + 1.0).sqrt();
            for (k, v) in [-p / length, -q / length, 1.0 / length].into_iter().enumerate() {
                planes.plane_mut(k)[at] = v as f32;
            }
        }
        planes
    }

    fn photograph(normals: &Planes, light: Direction, roughness: &dyn Fn(usize) -> f64, f0: f64) -> Raster {
        let l = light.to_array();
        let mut planes = Planes::zeros(normals.size(), 1);
        for at in 0..normals.size().texels() {
            let n: [f64; 3] = std::array::from_fn(|k| f64::from(normals.plane(k)[at]));
            let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
            let half = [l[0], l[1], l[2] + 1.0];
            let length = dot(half, half).sqrt();
            let (n_l, n_v) = (dot(n, l).max(0.0), n[2]);
            let (n_h, l_h) = (dot(n, half) / length, dot(l, half) / length);
            let lobe = specular(n_l, n_v, n_h, l_h, alpha(roughness(at)), f0);
            planes.plane_mut(0)[at] = (n_l * (0.3 * body_share(n_l, n_v, f0) + lobe)).min(4.0) as f32;
        }
        Raster::new(normals.size(), 1, Samples::F32(planes.plane(0).to_vec())).unwrap()
    }

    #[test]
    fn the_roughness_and_strength_of_a_lobe_are_found() {
        let (size, lights) = (Size::new(40, 30), lights());
        let normals = normals(size);
        for (rough, f0) in [(0.3, 0.04), (0.5, 0.04), (0.7, 0.04), (0.5, 0.06)] {
            let load = |i: usize| Ok(photograph(&normals, lights[i].1, &|_| rough, f0));
            let input = StereoInput { lights: &lights, lamps: None, load: &load };
            let found = highlights(input, &normals, HighlightOptions::default(), &Job::default()).unwrap();
            assert!((found.overall - rough).abs() < 0.08, "{rough}: {}", found.overall);
            let mean = |planes: &Planes| {
                planes.plane(0).iter().map(|v| f64::from(*v)).sum::<f64>() / size.texels() as f64
            };
            assert!((mean(&found.roughness) - rough).abs() < 0.1, "{rough}: {}", mean(&found.roughness));
            let strength = mean(&found.reflectance) / f0;
            assert!((0.6..1.5).contains(&strength), "{rough}: {strength}");
        }
    }

    #[test]
    fn two_parts_of_a_surface_have_their_own_roughness() {
        let (size, lights) = (Size::new(48, 32), lights());
        let normals = normals(size);
        let rough = |at: usize| if at % 48 < 24 { 0.3 } else { 0.6 };
        let load = |i: usize| Ok(photograph(&normals, lights[i].1, &rough, 0.04));
        let input = StereoInput { lights: &lights, lamps: None, load: &load };
        let found = highlights(input, &normals, HighlightOptions::default(), &Job::default()).unwrap();
        let mean = |from: usize| {
            let of = (0..size.texels()).filter(|at| (from..from + 16).contains(&(at % 48)));
            let values: Vec<f64> = of.map(|at| f64::from(found.roughness.plane(0)[at])).collect();
            values.iter().sum::<f64>() / values.len() as f64
        };
        assert!((mean(2) - 0.3).abs() < 0.08 && (mean(30) - 0.6).abs() < 0.1, "{} {}", mean(2), mean(30));
    }

    #[test]
    fn what_cannot_be_estimated_is_refused() {
        let (size, lights) = (Size::new(4, 4), lights());
        let normals = normals(size);
        let load = |i: usize| Ok(photograph(&normals, lights[i].1, &|_| 0.5, 0.04));
        let input = StereoInput { lights: &lights[..8], lamps: None, load: &load };
        let few = highlights(input, &normals, HighlightOptions::default(), &Job::default()).unwrap_err();
        assert!(few.to_string().contains("at least 12 lights, found 8"), "{few}");
    }
}
