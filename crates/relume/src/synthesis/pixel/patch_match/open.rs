//! Outputs with a border: the optimisation works on a torus, where opposite borders meet. A margin between them, which is
//! cut off afterwards, takes what does not fit; without it a guide that differs from side to side left a frame of mixtures.

use super::PatchMatchOptions;
use crate::planes::Planes;
use crate::size::Size;
use crate::synthesis::options::Boundary;
use crate::synthesis::source_map::{SourceMap, Texel};

/// The width of the margin in patches.
const PATCHES: usize = 4;

/// The options of an output on a torus, with a margin to the right and below whose guide continues both borders.
pub fn with_margin(options: &PatchMatchOptions) -> PatchMatchOptions {
    let margin = PATCHES * options.window;
    let size = Size::new(options.size.width + margin, options.size.height + margin);
    let guidance = options.guidance.clone().map(|mut guidance| {
        guidance.target = widened(&guidance.target, size);
        guidance
    });
    PatchMatchOptions { size, guidance, boundary: Boundary::Torus, ..options.clone() }
}

/// The part of a map without its margin.
pub fn without_margin(map: &SourceMap, size: Size) -> SourceMap {
    let texels = (0..size.height).flat_map(|y| (0..size.width).map(move |x| (x, y)));
    let copies: Vec<Texel> = texels.map(|(x, y)| map.copies()[map.size().index(x, y)]).collect();
    map.with_copies(size, copies)
}

/// Planes whose margin continues the right border, then the left one; below likewise.
fn widened(planes: &Planes, size: Size) -> Planes {
    let own = planes.size();
    let along = |at: usize, side: usize, wide: usize| match at {
        _ if at < side => at,
        _ if 2 * (at - side) < wide - side => side - 1,
        _ => 0,
    };
    let mut out = Planes::zeros(size, planes.count());
    for (wide, plane) in out.iter_mut().zip(planes.iter()) {
        for (i, value) in wide.iter_mut().enumerate() {
            let (x, y) = (i % size.width, i / size.width);
            let place = own.index(along(x, own.width, size.width), along(y, own.height, size.height));
            *value = plane[place];
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::job::Job;
    use crate::synthesis::Exemplar;
    use crate::synthesis::guidance::Guidance;
    use crate::synthesis::pixel::patch_match::patch_match;

    /// A former fault: a texture that is dark on the left and bright on the right, and follows a guide that says so, had mixtures
    /// of both along its borders.
    #[test]
    fn a_guided_texture_has_no_frame_of_mixtures() {
        let ramp = |size: Size| {
            let value = |i: usize| (i % size.width) as f32 / (size.width - 1) as f32;
            Planes::from_vec(size, 1, (0..size.texels()).map(value).collect()).unwrap()
        };
        let (own, size) = (Size::new(48, 48), Size::new(80, 40));
        let index = ramp(own);
        let exemplars = [Exemplar { index: &index, excluded: None }];
        let guidance = Some(Guidance { sources: vec![ramp(own)], target: ramp(size), weight: 1.0 });
        let errors = [Boundary::Open, Boundary::Torus].map(|boundary| {
            let guidance = guidance.clone();
            let options = PatchMatchOptions { size, boundary, guidance, window: 7, ..Default::default() };
            let (map, _) = patch_match(&exemplars, &options, &Job::default()).unwrap();
            assert_eq!(map.size(), size);
            let (guide, exemplar) = (ramp(size), ramp(own));
            let border =
                (0..size.texels()).filter(|i| i % size.width < 3 || i % size.width >= size.width - 3);
            let apart = border.map(|i| {
                let source = map.copies()[i];
                (exemplar.at(0, source.x as usize, source.y as usize) - guide.plane(0)[i]).abs()
            });
            apart.fold(0.0, f32::max)
        });
        assert!(errors[0] < 0.1 && errors[1] > 2.0 * errors[0], "{errors:?}");
    }

    #[test]
    fn the_margin_continues_both_borders() {
        let planes = Planes::from_vec(Size::new(3, 2), 1, vec![0.0, 1.0, 2.0, 3.0, 4.0, 5.0]).unwrap();
        let wide = widened(&planes, Size::new(7, 4));
        assert_eq!(&wide.plane(0)[..7], [0.0, 1.0, 2.0, 2.0, 2.0, 0.0, 0.0]);
        assert_eq!(
            &wide.plane(0)[14..],
            [3.0, 4.0, 5.0, 5.0, 5.0, 3.0, 3.0, 0.0, 1.0, 2.0, 2.0, 2.0, 0.0, 0.0]
        );
    }
}
