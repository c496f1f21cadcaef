//! Bidirectional texture functions: images for pairs of light and view, by a virtual gonioreflectometer.

use relume::capture::dome::sampling::{all_pairs, random_pairs, spread_directions};
use relume::capture::dome::{DirectionSampling, Gonioreflectometer};
use relume::direction::Directions;
use relume::workflow::capture::PhotographFormat;
use relume::workflow::gonioreflectometer::{footprint, images};
use relume::{Direction, Error, Named, Result, Space};
use serde_json::{Value, json};

use super::{Args, CapturedSurface, append, conditions, ignored, source, summary, truth};
use crate::context::Context;
use crate::output::FolderOrArchive;
use crate::report::{Report, counted};

/// Options of a bidirectional texture function.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Light and view")]
pub struct BtfArgs {
    /// Images for all pairs of light and view of a set of directions, rectified to the surface: `bonn` (81 x 81),
    /// `dome` (151 x 151), or N random views that keep apart, none of them from straight above
    #[arg(long, value_name = "bonn|dome|N", value_parser = views)]
    views: Option<Views>,
    /// Images for N random pairs of light and view
    #[arg(long, value_name = "N", conflicts_with_all = ["views", "lights"],
        value_parser = clap::value_parser!(u32).range(1..=MAX_IMAGES as i64))]
    pairs: Option<u32>,
    /// Another seed gives other random directions [default: 0]
    #[arg(long, value_name = "N")]
    direction_seed: Option<u64>,
}

/// The most images of one output.
const MAX_IMAGES: usize = 1_000_000;

/// A set of directions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Views {
    /// Those of a measuring device.
    Of(DirectionSampling),
    /// Random ones.
    Random(u32),
}

fn views(text: &str) -> std::result::Result<Views, String> {
    let number = || text.parse().ok().filter(|n| (1..=10_000).contains(n)).map(Views::Random);
    let named = DirectionSampling::from_name(text).map(Views::Of);
    named.or_else(number).ok_or_else(|| "expected bonn, dome, or a number from 1 to 10000".to_owned())
}

/// Pairs of directions, and what is said of them.
pub struct MeasuredPairs {
    pairs: Vec<Directions>,
    description: Value,
}

impl BtfArgs {
    /// The pairs that are asked for, if any.
    ///
    /// # Errors
    /// Options without a meaning together, or more than a million images.
    pub fn pairs(&self, lights: Option<u32>) -> Result<Option<MeasuredPairs>> {
        let seed = self.direction_seed.unwrap_or(0);
        let measured = match (self.views, self.pairs) {
            (Some(Views::Of(_)), _) if lights.is_some() => {
                return Err(Error::usage(
                    "--lights cannot be used with a named set of --views, which has its own",
                ));
            }
            (Some(Views::Of(_)), _) | (None, None) if self.direction_seed.is_some() => {
                return Err(Error::usage(
                    "--direction-seed is for random directions: --views N or --pairs N",
                ));
            }
            (Some(Views::Of(sampling)), _) => {
                let directions = sampling.directions();
                MeasuredPairs::grid(sampling.name(), &directions, &directions)
            }
            (Some(Views::Random(views)), _) => {
                let lights = spread_directions(lights.unwrap_or(views) as usize, seed);
                if lights.len() * views as usize > MAX_IMAGES {
                    return Err(Error::usage(format!(
                        "{} and {} are {} images: expected at most {MAX_IMAGES}",
                        counted(lights.len(), "light"),
                        counted(views as usize, "view"),
                        lights.len() * views as usize
                    )));
                }
                MeasuredPairs::grid("random", &lights, &spread_directions(views as usize, seed))
                    .with_seed(seed)
            }
            (None, Some(count)) => MeasuredPairs {
                pairs: random_pairs(count as usize, seed),
                description: json!({ "sampling": "pairs", "lights": count, "views": count, "images": count }),
            }
            .with_seed(seed),
            (None, None) => return Ok(None),
        };
        Ok(Some(measured))
    }
}

impl MeasuredPairs {
    fn grid(sampling: &str, lights: &[Direction], views: &[Direction]) -> Self {
        let pairs = all_pairs(lights, views);
        let description = json!({
            "sampling": sampling,
            "lights": lights.len(),
            "views": views.len(),
            "images": pairs.len(),
        });
        Self { pairs, description }
    }

    fn with_seed(mut self, seed: u64) -> Self {
        self.description["direction_seed"] = seed.into();
        self
    }
}

/// Measures the surface for all pairs and writes the images.
pub fn run(args: &Args, measured: MeasuredPairs, context: &Context) -> Result<Report> {
    let (format, options) = (args.format.unwrap_or(PhotographFormat::Jpeg), args.dome.options(0.0));
    options.validate()?;
    let output = FolderOrArchive::claim(&args.output, &args.inputs(), context)?;
    let CapturedSurface { name, dome, unused } =
        source(args, &options, &|size| footprint(size, format), context)?;
    let mut json = json!({ "source": &name, "width": dome.size().width, "height": dome.size().height });
    append(&mut json, measured.description);
    let device = Gonioreflectometer::new(dome, measured.pairs, &context.job)?;
    append(&mut json, meaning(format));
    let (clipped, written) = output.write(|keep| {
        let clipped = images(&device, format, &context.job, keep)?;
        truth::write(device.dome(), keep, &context.job)?;
        append(&mut json, conditions(args, device.dome(), clipped));
        keep("capture.json", format!("{json:#}\n").as_bytes())?;
        Ok(clipped)
    })?;
    let what = counted(device.pairs().len(), "image");
    let report = Report::new(summary(args, &what, &name, device.dome(), clipped), json);
    Ok(report.with_outputs(written).with_warnings(ignored(&unused)))
}

/// What the values and the pixels of the images are.
fn meaning(format: PhotographFormat) -> Value {
    json!({
        "names": "tvT_pvP/NUMBER tlT plP tvT pvP: polar (t) and azimuth (p) angles of light (l) and view (v) in degrees",
        "encoding": if format.space() == Space::Srgb { "srgb" } else { "linear" },
        "holds_cosine": true,
        "rectified": "pixel (x, y) is texel (x, y) of the plane at the mean height",
    })
}
