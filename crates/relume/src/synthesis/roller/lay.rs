//! A texture of a given size laid from a tile set, as a source map: the window of [`super::Endless`] from (0,
//! 0) on, so that anything registered with the exemplar can be laid in the same way.

use super::Endless;
use super::tile_set::TileSet;
use crate::error::{Error, Result};
use crate::job::Job;
use crate::size::Size;
use crate::synthesis::options::Boundary;
use crate::synthesis::source_map::{SourceMap, Texel};

/// Lays tiles side by side, each chosen by a hash of the seed and the cell.
///
/// # Errors
/// When the output has to tile and does not contain whole tiles, has no texels, or exceeds the limits.
pub fn lay(tiles: &TileSet, size: Size, boundary: Boundary, seed: u64, job: &Job) -> Result<SourceMap> {
    job.check("the source map", size, size_of::<Texel>() as u64)?;
    if size.texels() == 0 {
        return Err(Error::usage(format!("an output of {size} texels: both sides must be at least 1")));
    }
    if boundary == Boundary::Torus && !tiles.cells().are_upright() {
        return Err(Error::usage("oblique tiles do not close on a rectangle: make upright ones"));
    }
    let Size { width, height } = tiles.tile();
    let whole = size.width.is_multiple_of(width) && size.height.is_multiple_of(height);
    if boundary == Boundary::Torus && !whole {
        let near = |side: usize, tile: usize| (side / tile).max(1) * tile;
        return Err(Error::usage(format!(
            "an output of {size} texels cannot tile: it must hold whole tiles of {}, such as {} does",
            tiles.tile(),
            Size::new(near(size.width, width), near(size.height, height))
        )));
    }
    let plane = Endless::of(*tiles.cells(), tiles.count(), seed)?.with_corners(tiles.corners());
    let plane = match boundary {
        Boundary::Torus => plane.repeating(size.width / width, size.height / height),
        Boundary::Open => plane,
    };
    let mut copies = vec![Texel::default(); size.texels()];
    for (y, row) in copies.chunks_exact_mut(size.width).enumerate() {
        plane.copy_row(tiles.map().copies(), 1, 0, y as i64, row);
    }
    Ok(tiles.map().with_copies(size, copies))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::limits::Limits;
    use crate::planes::Planes;
    use crate::synthesis::quantise::Exemplar;
    use crate::synthesis::roller::{RollerOptions, roll};

    fn tiles() -> TileSet {
        let size = Size::new(48, 40);
        let wave = |i: usize| ((i % 48) as f32 * 0.785).sin() + ((i / 48) as f32 * 0.628).sin();
        let index = Planes::from_vec(size, 1, (0..size.texels()).map(wave).collect()).unwrap();
        let options = RollerOptions { tiles: 3, ..RollerOptions::default() };
        roll(&Exemplar { index: &index, excluded: None }, &options, &Job::default()).unwrap().tiles
    }

    #[test]
    fn every_texel_is_that_of_the_endless_plane() {
        let (tiles, size) = (tiles(), Size::new(61, 53));
        let map = lay(&tiles, size, Boundary::Open, 7, &Job::default()).unwrap();
        assert_eq!((map.size(), map.exemplars()), (size, &[Size::new(48, 40)][..]));
        let plane = Endless::new(tiles.tile(), tiles.count(), 7).unwrap();
        for (i, copy) in map.copies().iter().enumerate() {
            let from = plane.texel_at((i % 61) as i64, (i / 61) as i64);
            assert_eq!(*copy, tiles.sources(from.tile)[tiles.tile().index(from.x, from.y)]);
        }
    }

    #[test]
    fn only_whole_tiles_close_on_themselves() {
        let (tiles, job) = (tiles(), Job::default());
        let Size { width, height } = tiles.tile();
        let torus = |size| lay(&tiles, size, Boundary::Torus, 0, &job);
        assert!(torus(Size::new(3 * width, 2 * height)).is_ok());
        let error = torus(Size::new(3 * width + 1, 2 * height)).unwrap_err();
        assert!(error.message().contains(&Size::new(3 * width, 2 * height).to_string()), "{error}");
        assert!(lay(&tiles, Size::new(0, 4), Boundary::Open, 0, &job).is_err());
        let tight = Job::new(Limits { max_bytes: 99, ..Limits::default() });
        assert!(lay(&tiles, Size::new(9, 9), Boundary::Open, 0, &tight).is_err());
    }
}
