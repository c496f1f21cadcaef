//! An endless plane in files of squares of texels, each made when it is asked for.

use super::header::ShareBlocks;
use super::planes;
use super::{ShareFiles, ShareHeader, shared_basis};
use crate::error::Result;
use crate::field::ReflectanceField;
use crate::job::Job;
use crate::size::Size;

/// The side of a square in texels: large enough that what surrounds it in its making counts little.
pub const BLOCK_SIDE: usize = 256;

const BEFORE: &str = "block_";
const AFTER: &str = ".f16.gz";

impl ShareFiles {
    /// The files of a plane of textures like `like`, but for those of its squares; `size` is what viewers take for one repetition.
    ///
    /// # Errors
    /// As [`ShareFiles::new`].
    pub fn of_blocks(
        like: &ReflectanceField,
        size: Size,
        title: &str,
        mm_per_texel: Option<f64>,
        job: &Job,
    ) -> Result<Self> {
        super::check_color(like)?;
        let mut files = Vec::new();
        let basis = shared_basis(like, &mut files, job)?;
        let header = ShareHeader {
            size: [size.width, size.height],
            mm_per_texel,
            blocks: Some(ShareBlocks { side: BLOCK_SIDE }),
            ..ShareHeader::empty(title, like, basis)
        };
        Ok(Self { header, files })
    }
}

/// The name of the square in a column and row, counted from the one whose upper left texel is (0, 0).
pub fn block_name([column, row]: [i64; 2]) -> String {
    format!("{BEFORE}{column}_{row}{AFTER}")
}

/// The column and row of a name that [`block_name`] gives; `None` for any other name.
pub fn block_of(name: &str) -> Option<[i64; 2]> {
    let (column, row) = name.strip_prefix(BEFORE)?.strip_suffix(AFTER)?.split_once('_')?;
    let place = [column.parse().ok()?, row.parse().ok()?];
    (block_name(place) == name).then_some(place)
}

/// The file of a square: its planes one after another as compressed half floats.
pub fn block_bytes(field: &ReflectanceField) -> Vec<u8> {
    planes::halves(field.coefficients().as_slice())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_blocks_have_one_form() {
        for place in [[0, 0], [-1, 17], [i64::MAX, i64::MIN]] {
            assert_eq!(block_of(&block_name(place)), Some(place));
        }
        for bad in [
            "block_+1_0.f16.gz",
            "block_01_0.f16.gz",
            "block_-0_0.f16.gz",
            "block_1.f16.gz",
            "block_1_2_3.f16.gz",
            "",
        ] {
            assert_eq!(block_of(bad), None, "{bad}");
        }
    }
}
