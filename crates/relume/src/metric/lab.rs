//! Differences of pictures as colours.

use super::ciede2000::ciede2000;
use crate::error::{Error, Result};
use crate::lab;
use crate::picture::Picture;

/// Mean differences of the texels of two pictures.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LabErrors {
    /// The mean absolute difference of CIE L*, a* and b*.
    pub mae_lab: f64,
    /// The mean of CIEDE2000.
    pub ciede2000: f64,
}

/// The differences of two pictures in colour or grey, clamped to 0..1.
///
/// # Errors
/// When sizes or numbers of planes differ, and for pictures with other than one or three planes.
pub fn lab_errors(a: &Picture, b: &Picture) -> Result<LabErrors> {
    let kind = |picture: &Picture| (picture.size(), picture.planes.count());
    if kind(a) != kind(b) || !matches!(a.planes.count(), 1 | 3) {
        return Err(Error::usage(format!(
            "colours of {} planes of {} cannot be compared with {} planes of {}: both must be pictures of the same size",
            a.planes.count(),
            a.size(),
            b.planes.count(),
            b.size()
        )));
    }
    let color = |picture: &Picture, texel: usize| {
        lab::from_linear(std::array::from_fn(|c| {
            let value = picture.planes.plane(c.min(picture.planes.count() - 1))[texel];
            f64::from(picture.space.to_linear(value.clamp(0.0, 1.0)))
        }))
    };
    let mut sums = [0.0; 2];
    for texel in 0..a.size().texels() {
        let (p, q) = (color(a, texel), color(b, texel));
        sums[0] += p.iter().zip(q).map(|(x, y)| (x - y).abs()).sum::<f64>() / 3.0;
        sums[1] += ciede2000(p, q);
    }
    let [mae_lab, ciede2000] = sums.map(|sum| sum / a.size().texels() as f64);
    Ok(LabErrors { mae_lab, ciede2000 })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planes::Planes;
    use crate::size::Size;
    use crate::space::Space;

    #[test]
    fn greys_differ_by_their_lightness() {
        let picture = |value: f32| Picture {
            planes: Planes::from_vec(Size::new(2, 2), 1, vec![value; 4]).unwrap(),
            space: Space::Linear,
        };
        let errors = lab_errors(&picture(1.0), &picture(0.184_186_52)).unwrap();
        // L* of 100 and 50, a* and b* equal.
        assert!((errors.mae_lab - 50.0 / 3.0).abs() < 0.01, "{errors:?}");
        assert!(errors.ciede2000 > 30.0);
        let colored = Picture { planes: Planes::zeros(Size::new(2, 2), 3), space: Space::Linear };
        assert!(lab_errors(&picture(1.0), &colored).is_err());
    }
}
