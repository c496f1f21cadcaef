//! Height maps joined by their slopes.

use super::RegisteredMap;
use crate::error::{Error, Result};
use crate::field::ReflectanceField;
use crate::job::Job;
use crate::surface::integrate::{Differences, SurfaceBorder, anchored};
use crate::synthesis::{SourceMap, Texel, gather};

/// The wavelength in texels up to which joined heights follow their slopes.
pub const LONGEST_JOINED: f64 = 64.0;

/// The height map made by applying a source map, with pieces joined by their slopes instead of copied: no cliffs
/// at cuts. Heights change a little; undulations beyond [`LONGEST_JOINED`] stay as they were.
///
/// # Errors
/// As [`gather`], and fields of other than one plane.
pub fn join_heights(
    map: &SourceMap,
    registered: &RegisteredMap<'_>,
    border: SurfaceBorder,
    job: &Job,
) -> Result<ReflectanceField> {
    let copied = gather(map, &registered.fields, job)?;
    if copied.coefficients().count() != 1 {
        return Err(Error::usage(format!(
            "heights are joined by their slopes in maps of one channel, found {}",
            copied.coefficients().count()
        )));
    }
    job.check("the differences of heights", map.size(), 16)?;
    let differences = Differences {
        right: differences(map, &registered.fields, [1, 0], border),
        down: differences(map, &registered.fields, [0, 1], border),
    };
    let joined = anchored(&differences, copied.coefficients(), LONGEST_JOINED, border, job)?;
    copied.with_coefficients(joined)
}

/// The differences from each texel to its neighbour at [dx, dy]: those of the exemplar, and at cuts the mean of
/// the differences on both sides. Beyond an open border they are 0.
fn differences(
    map: &SourceMap,
    fields: &[&ReflectanceField],
    [dx, dy]: [usize; 2],
    border: SurfaceBorder,
) -> Vec<f64> {
    let size = map.size();
    let difference = |texel: usize| {
        let (x, y) = (texel % size.width + dx, texel / size.width + dy);
        if border == SurfaceBorder::Open && (x == size.width || y == size.height) {
            return 0.0;
        }
        let next = size.index(x % size.width, y % size.height);
        let (from, to) = (map.copies()[texel], map.copies()[next]);
        0.5 * (slope_after(fields, from, [dx, dy]) + slope_before(fields, to, [dx, dy]))
    };
    (0..size.texels()).map(difference).collect()
}

/// The difference from a texel of an exemplar to the next one, or, at its border, to it from the one before.
fn slope_after(fields: &[&ReflectanceField], texel: Texel, [dx, dy]: [usize; 2]) -> f64 {
    let size = fields[texel.exemplar as usize].size();
    let (x, y) = (texel.x as usize, texel.y as usize);
    let is_last = x + dx >= size.width || y + dy >= size.height;
    if !is_last {
        height(fields, texel.offset(dx, dy)) - height(fields, texel)
    } else if x >= dx && y >= dy {
        height(fields, texel) - height(fields, before(texel, dx, dy))
    } else {
        0.0
    }
}

/// The difference to a texel of an exemplar from the one before, or, at its border, from it to the next one.
fn slope_before(fields: &[&ReflectanceField], texel: Texel, [dx, dy]: [usize; 2]) -> f64 {
    if texel.x as usize >= dx && texel.y as usize >= dy {
        return height(fields, texel) - height(fields, before(texel, dx, dy));
    }
    let size = fields[texel.exemplar as usize].size();
    let is_last = texel.x as usize + dx >= size.width || texel.y as usize + dy >= size.height;
    if is_last { 0.0 } else { height(fields, texel.offset(dx, dy)) - height(fields, texel) }
}

/// The texel farther left or up; it exists.
fn before(texel: Texel, dx: usize, dy: usize) -> Texel {
    Texel { x: texel.x - dx as u32, y: texel.y - dy as u32, ..texel }
}

fn height(fields: &[&ReflectanceField], at: Texel) -> f64 {
    f64::from(fields[at.exemplar as usize].coefficients().at(0, at.x as usize, at.y as usize))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::format::MapRole;
    use crate::picture::Picture;
    use crate::planes::Planes;
    use crate::size::Size;
    use crate::space::Space;
    use crate::synthesis::{BlockOptions, Boundary, Exemplar, synthesize};

    /// A slope with ripples: any two blocks of it meet in a cliff.
    fn slope(size: Size) -> ReflectanceField {
        let height = |texel: usize| {
            let (x, y) = ((texel % size.width) as f32, (texel / size.width) as f32);
            0.3 + 0.01 * (x + 0.5 * y) + 0.02 * (x * 0.7).sin()
        };
        let planes = Planes::from_vec(size, 1, (0..size.texels()).map(height).collect()).unwrap();
        ReflectanceField::from_picture(Picture { planes, space: Space::Srgb })
    }

    fn largest_step(field: &ReflectanceField, border: SurfaceBorder) -> f32 {
        let (size, plane) = (field.size(), field.coefficients().plane(0));
        let mut largest = 0.0f32;
        for texel in 0..size.texels() {
            let (x, y) = (texel % size.width, texel / size.width);
            for (nx, ny) in [(x + 1, y), (x, y + 1)] {
                if border == SurfaceBorder::Periodic || (nx < size.width && ny < size.height) {
                    let next = size.index(nx % size.width, ny % size.height);
                    largest = largest.max((plane[next] - plane[texel]).abs());
                }
            }
        }
        largest
    }

    #[test]
    fn joined_heights_have_no_cliffs_also_across_the_border_of_a_tile() {
        let field = slope(Size::new(64, 64));
        let flat = Planes::zeros(field.size(), 1);
        for (boundary, border) in
            [(Boundary::Open, SurfaceBorder::Open), (Boundary::Torus, SurfaceBorder::Periodic)]
        {
            let exemplar = [Exemplar { index: &flat, excluded: None }];
            let options = BlockOptions {
                size: Size::new(80, 72),
                block: 24,
                overlap: 8,
                boundary,
                ..BlockOptions::default()
            };
            let map = synthesize(&exemplar, &options, &Job::default()).unwrap().map;
            let registered = RegisteredMap { role: MapRole::Height, fields: vec![&field] };
            let copied = gather(&map, &[&field], &Job::default()).unwrap();
            let joined = join_heights(&map, &registered, border, &Job::default()).unwrap();
            let natural = largest_step(&field, SurfaceBorder::Open);
            assert!(largest_step(&copied, border) > 5.0 * natural);
            let step = largest_step(&joined, border);
            assert!(step < 2.5 * natural, "{border:?}: {step}, {natural}");
        }
    }

    #[test]
    fn heights_of_one_piece_stay_what_they_are() {
        let field = slope(Size::new(32, 32));
        let exemplar = [Exemplar { index: field.coefficients(), excluded: None }];
        let options =
            BlockOptions { size: Size::new(24, 24), block: 24, overlap: 4, ..BlockOptions::default() };
        let map = synthesize(&exemplar, &options, &Job::default()).unwrap().map;
        let registered = RegisteredMap { role: MapRole::Height, fields: vec![&field] };
        let copied = gather(&map, &[&field], &Job::default()).unwrap();
        let joined = join_heights(&map, &registered, SurfaceBorder::Open, &Job::default()).unwrap();
        for (a, b) in joined.coefficients().as_slice().iter().zip(copied.coefficients().as_slice()) {
            assert!((a - b).abs() < 1e-5);
        }
    }
}
