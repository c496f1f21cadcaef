//! Windows of the plane that noise makes of an exemplar.

use relume::field::{Domain, IndexSpace, Metric};
use relume::format::{Encoding, FieldFile, FieldFormat, Streamed, decode_field, encode_field};
use relume::synthesis::noise::{Noise, NoiseOptions};
use relume::{Error, Limits, Result, Size};
use serde_json::json;

use super::{Job, Window};
use crate::context::Context;
use crate::input;
use crate::report::Report;

/// Samples that one band of rows holds at most, over all index planes.
const BAND_SAMPLES: usize = 1 << 23;

/// Computes the window in bands of rows.
pub fn draw(job: &Job<'_>, context: &Context) -> Result<Report> {
    let [path] = job.exemplars else {
        return Err(Error::usage("--method noise makes a texture of one exemplar: give one"));
    };
    let window = job.window()?;
    let file = input::field(path, &context.limits)?;
    let space = IndexSpace::new(&file.field, Metric::Function, Domain::Hemisphere)?;
    let bytes = 4 * space.planes() as u64;
    context.limits.check("the index of the exemplar", file.field.size(), bytes)?;
    let options = NoiseOptions { side: job.args.triangle, seed: job.seed };
    let noise =
        Noise::new(&space.index_planes(&file.field), &options, &context.limits).map_err(|e| e.at(path))?;
    let format = job.format(&file.encoding)?;
    let encoding = encoding(&file, format, &context.limits).map_err(|e| e.at(job.output))?;
    let head =
        Streamed::new(&file.field, format, Some(&encoding), &context.limits).map_err(|e| e.at(job.output))?;
    let height = (BAND_SAMPLES / (window.size.width * space.planes()).max(1)).clamp(1, 64);
    let mut bands = Bands {
        noise: &noise,
        space: &space,
        file: &file,
        stored: (format, encoding),
        window,
        height,
        limits: &context.limits,
        current: None,
    };
    job.write(&head, window.size, context, &mut |lane, y, row| bands.row(lane, y, row))?;
    let details = json!({ "triangle": noise.side(), "measured": noise.suitability() });
    Ok(job.report(window, &format!("of noise in triangles of {:.1}", noise.side()), details))
}

/// How the output stores its values: the same for all bands.
fn encoding(file: &FieldFile, format: FieldFormat, limits: &Limits) -> Result<Encoding> {
    match (format, file.encoding) {
        (FieldFormat::Ptm, encoding) if !matches!(encoding, Encoding::Ptm(_)) => {
            Ok(decode_field(&encode_field(&file.field, format, None, limits)?, limits)?.encoding)
        }
        (_, encoding) => Ok(encoding),
    }
}

/// The rows of a window, computed a band at a time.
struct Bands<'a> {
    noise: &'a Noise,
    space: &'a IndexSpace,
    file: &'a FieldFile,
    stored: (FieldFormat, Encoding),
    window: Window,
    /// Rows of a band.
    height: usize,
    limits: &'a Limits,
    /// The number of the band at hand, and its bytes.
    current: Option<(usize, Streamed)>,
}

impl Bands<'_> {
    fn row(&mut self, lane: usize, y: usize, row: &mut [u8]) -> Result<()> {
        let number = y / self.height;
        let band = match self.current.take().filter(|(current, _)| *current == number) {
            Some((_, band)) => band,
            None => self.compute(number)?,
        };
        let start = y % self.height * row.len();
        row.copy_from_slice(&band.lanes()[lane].data[start..][..row.len()]);
        self.current = Some((number, band));
        Ok(())
    }

    fn compute(&self, band: usize) -> Result<Streamed> {
        let Window { x, y, size } = self.window;
        let first = band * self.height;
        let size = Size::new(size.width, self.height.min(size.height - first));
        let index = self.noise.window(x, y + first as i64, size, self.limits)?;
        let field = self.space.field(&self.file.field, &index)?;
        Streamed::new(&field, self.stored.0, Some(&self.stored.1), self.limits)
    }
}
