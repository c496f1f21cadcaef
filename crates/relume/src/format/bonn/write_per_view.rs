//! Writing of `.btf` files factored for each view (PVF). The most used small reader does not take them; the library of the
//! database does.

use super::factors::{BtfFactors, FactorShape};
use super::grid::ViewLightGrid;
use super::write::{begun, check_factors, put, texel_rows};
use super::{BtfScalar, CHANNELS};
use crate::direction::Directions;
use crate::error::{Error, Result};
use crate::job::Job;

/// The factors of some pairs with one view: of the light and the channel, in the order of `pairs`.
#[derive(Debug, Clone)]
pub struct ViewPart {
    /// The numbers of the pairs in the list of all.
    pub pairs: Vec<usize>,
    /// Functions of pair and channel ([`FactorShape::Functions`], three channels).
    pub factors: BtfFactors,
}

/// The bytes of a `.btf` file of factors for each view. Values do not contain the cosine
/// ([`BtfFactors::without_cosine`]).
///
/// # Errors
/// Pairs that are not every view with every light, parts that are not the views, numbers beyond the range of `scalar`, and
/// limits.
pub fn encode_pvf(pairs: &[Directions], parts: &[ViewPart], scalar: BtfScalar, job: &Job) -> Result<Vec<u8>> {
    let grid = ViewLightGrid::of(pairs)?;
    let lights = grid.lights.len();
    for part in parts {
        check_factors(
            "the factors of a view",
            &part.factors,
            FactorShape::Functions,
            part.pairs.len() * CHANNELS,
        )?;
    }
    let all: Vec<&BtfFactors> = parts.iter().map(|part| &part.factors).collect();
    let size = all.first().map(|first| first.coefficients.size());
    let size = size.filter(|size| all.iter().all(|factors| factors.coefficients.size() == *size));
    let size = size.ok_or_else(|| Error::invalid("the factors of views are of textures of one size"))?;
    let mut out = begun(b"!PVF06FCR", &grid, size, &all, scalar, job)?;
    let most = all.iter().map(|factors| factors.count()).max().unwrap_or(0);
    put(&mut out, &[most as u32, grid.views.len() as u32]);
    for order in grid.order.chunks_exact(lights) {
        put_view(&mut out, &part_of(parts, order)?, scalar)?;
    }
    Ok(out)
}

/// The part of a view, and the place in it of each light in order.
fn part_of<'a>(parts: &'a [ViewPart], order: &[usize]) -> Result<(&'a BtfFactors, Vec<usize>)> {
    let found = parts.iter().find_map(|part| {
        let place = |pair: &usize| part.pairs.iter().position(|own| own == pair);
        let places: Option<Vec<usize>> = order.iter().map(place).collect();
        places.map(|places| (&part.factors, places))
    });
    found.ok_or_else(|| Error::invalid("the factors of a view do not hold all lights of it"))
}

fn put_view(
    out: &mut Vec<u8>,
    (factors, places): &(&BtfFactors, Vec<usize>),
    scalar: BtfScalar,
) -> Result<()> {
    let (count, width) = (factors.count(), CHANNELS * factors.count());
    let length = CHANNELS * places.len();
    out.push(scalar.bytes() as u8);
    put(out, &[count as u32, factors.coefficients.size().texels() as u32, length as u32]);
    let functions = places.iter().flat_map(|&place| &factors.functions[place * width..][..width]);
    let numbers = factors.singular.iter().copied();
    // No mean: the functions are those of values from 0.
    let numbers = numbers.chain(std::iter::repeat_n(0.0, length)).chain(functions.copied());
    let numbers = numbers.chain(texel_rows(&factors.coefficients));
    scalar.encode_into(numbers, out).ok_or_else(|| {
        Error::unsupported(
            "the factors of a view have a number that is not finite, or beyond 65,504 and so beyond halves: write floats",
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::direction::Direction;
    use crate::format::bonn::BonnBtf;
    use crate::planes::Planes;
    use crate::size::Size;

    #[test]
    fn every_image_of_a_file_of_views_is_its_factors_product() {
        let direction = |i: usize| Direction::from_angles(0.2 * (i + 1) as f64, 0.9 * i as f64);
        let (lights, views, size) = (4, 3, Size::new(3, 2));
        // Lights change last: not the order of the file.
        let pairs: Vec<Directions> = (0..lights * views)
            .map(|i| Directions { light: direction(i / views), view: direction(i % views) })
            .collect();
        let part = |view: usize| {
            let count = view + 1;
            let number = |i: usize| ((i * 37 + view * 11) % 17) as f32 / 8.0 - 1.0;
            let data = (0..count * size.texels()).map(number).collect();
            ViewPart {
                pairs: (0..lights).map(|light| light * views + view).collect(),
                factors: BtfFactors {
                    shape: FactorShape::Functions,
                    functions: (0..lights * CHANNELS * count).map(|i| number(i + 5)).collect(),
                    coefficients: Planes::from_vec(size, count, data).unwrap(),
                    singular: vec![1.0; count],
                },
            }
        };
        let parts: Vec<ViewPart> = (0..views).map(part).collect();
        let bytes = encode_pvf(&pairs, &parts, BtfScalar::Float, &Job::default()).unwrap();
        let btf = BonnBtf::decode(std::sync::Arc::new(bytes), &Job::default()).unwrap();
        for (i, pair) in btf.pairs().iter().enumerate() {
            let apart = |other: &Directions| 2.0 - other.light.dot(pair.light) - other.view.dot(pair.view);
            let own = pairs.iter().position(|other| apart(other) < 1e-6).unwrap();
            let (light, part) = (own / views, &parts[own % views]);
            let (image, count) = (btf.image(i, &Job::default()).unwrap(), part.factors.count());
            for (texel, c) in (0..size.texels()).flat_map(|t| (0..CHANNELS).map(move |c| (t, c))) {
                let row = &part.factors.functions[(light * CHANNELS + c) * count..][..count];
                let truth: f32 =
                    row.iter().enumerate().map(|(k, f)| f * part.factors.coefficients.plane(k)[texel]).sum();
                assert!((image.samples().value(texel * CHANNELS + c) - truth).abs() < 1e-5);
            }
        }
    }

    #[test]
    fn parts_that_are_not_the_views_are_refused() {
        let direction = |i: usize| Direction::from_angles(0.2 * (i + 1) as f64, 0.9 * i as f64);
        let pairs: Vec<Directions> =
            (0..4).map(|i| Directions { light: direction(i % 2), view: direction(i / 2) }).collect();
        let part = |pairs: Vec<usize>| ViewPart {
            factors: BtfFactors {
                shape: FactorShape::Functions,
                functions: vec![0.5; pairs.len() * CHANNELS],
                coefficients: Planes::zeros(Size::new(2, 1), 1),
                singular: vec![1.0],
            },
            pairs,
        };
        let message = |parts: &[ViewPart]| {
            encode_pvf(&pairs, parts, BtfScalar::Half, &Job::default()).unwrap_err().to_string()
        };
        assert!(message(&[part(vec![0, 1])]).contains("do not hold all lights"));
        assert!(message(&[part(vec![0, 2]), part(vec![1, 3])]).contains("do not hold all lights"));
        assert!(message(&[]).contains("of one size"));
    }
}
