//! Detection of samples that are not finite, when files are read: no stage can use them.

use crate::error::{Error, Result};
use crate::size::Size;

/// Refuses samples if one is NaN or infinite: the one at `i` lies in channel `channel(i)` at texel
/// `texel(i)`.
pub(super) fn check<'a>(
    samples: &[f32],
    size: Size,
    channel: impl Fn(usize) -> &'a str,
    texel: impl Fn(usize) -> usize,
) -> Result<()> {
    let Some(i) = samples.iter().position(|sample| !sample.is_finite()) else { return Ok(()) };
    let (x, y) = (texel(i) % size.width, texel(i) / size.width);
    let found = if samples[i].is_nan() { "NaN" } else { "infinite" };
    Err(Error::invalid(format!(
        "channel '{}' is {found} at texel ({x}, {y}), counted from the top left: expected finite numbers; replace \
         such texels first",
        channel(i)
    )))
}
