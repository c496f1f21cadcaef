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

/// Computes the window in bands of rows, or in the tiles of the file.
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
    let head = job.encoded(&file.field, format, Some(&encoding), context)?;
    let band = || (BAND_SAMPLES / (window.size.width * space.planes()).max(1)).clamp(1, 64);
    let mut parts = Parts {
        noise: &noise,
        space: &space,
        file: &file,
        stored: (format, encoding),
        window,
        part: job.args.exr_tile.unwrap_or_else(|| Size::new(window.size.width, band())),
        limits: &context.limits,
        current: None,
    };
    job.write(&head, window.size, context, &mut |lane, x, y, row| parts.row(lane, x, y, row))?;
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

/// A window computed part after part.
struct Parts<'a> {
    noise: &'a Noise,
    space: &'a IndexSpace,
    file: &'a FieldFile,
    stored: (FieldFormat, Encoding),
    window: Window,
    /// The size of a part.
    part: Size,
    limits: &'a Limits,
    /// Column and row of the part at hand, and its bytes.
    current: Option<([usize; 2], Streamed)>,
}

impl Parts<'_> {
    fn row(&mut self, lane: usize, x: usize, y: usize, row: &mut [u8]) -> Result<()> {
        let place = [x / self.part.width, y / self.part.height];
        let bytes = match self.current.take().filter(|(current, _)| *current == place) {
            Some((_, bytes)) => bytes,
            None => self.compute(self.extent(place))?,
        };
        let [left, top] = [place[0] * self.part.width, place[1] * self.part.height];
        bytes.lanes()[lane].copy_row(self.extent(place).size.width, x - left, y - top, row);
        self.current = Some((place, bytes));
        Ok(())
    }

    /// The texels of a part, which the window's end may cut.
    fn extent(&self, [column, row]: [usize; 2]) -> Window {
        let Window { x, y, size } = self.window;
        let (left, top) = (column * self.part.width, row * self.part.height);
        let (width, height) =
            (self.part.width.min(size.width - left), self.part.height.min(size.height - top));
        Window { x: x + left as i64, y: y + top as i64, size: Size::new(width, height) }
    }

    fn compute(&self, Window { x, y, size }: Window) -> Result<Streamed> {
        let index = self.noise.window(x, y, size, self.limits)?;
        let field = self.space.field(&self.file.field, &index)?;
        Streamed::new(&field, self.stored.0, Some(&self.stored.1), self.limits)
    }
}
