//! Luminance of linear red, green and blue, ITU-R BT.709-6.

use crate::planes::Planes;

/// The weights of red, green and blue.
pub(super) const LUMINANCE: [f64; 3] = [0.2126, 0.7152, 0.0722];

/// The luminance of one texel of one (grey) or three planes.
pub(super) fn of_texel(planes: &Planes, texel: usize) -> f64 {
    match planes.count() {
        1 => f64::from(planes.plane(0)[texel]),
        _ => (0..3).map(|c| LUMINANCE[c] * f64::from(planes.plane(c)[texel])).sum(),
    }
}

/// One plane of luminance of one (grey) or three linear planes.
pub fn luminance(planes: &Planes) -> Planes {
    let mut out = Planes::zeros(planes.size(), 1);
    out.plane_mut(0).iter_mut().enumerate().for_each(|(texel, v)| *v = of_texel(planes, texel) as f32);
    out
}
