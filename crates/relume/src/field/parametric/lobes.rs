//! Cosine lobes (E. P. F. Lafortune, S.-C. Foo, K. E. Torrance, D. P. Greenberg, "Non-Linear Approximation of Reflectance
//! Functions", SIGGRAPH 1997, equation 8): a diffuse part, and for each lobe a colour times a power of a weighted sum of
//! the products of the components of light and view,
//!
//! f(l, v) = d + sum_k s_k max(0, x_k l_x v_x + y_k l_y v_y + z_k l_z v_z)^n_k,
//!
//! times the cosine l_z between light and texture: the radiance that a photograph holds, 1 for a white surface that faces
//! the light. Weights of -1, -1, 1 are the mirror's direction. Lobes of one view have the components of the light alone
//! instead of products. The length of the weights is free in this formula, for the colour makes up for it: fits make the
//! largest weight 1, of one view the length 1, so that the colour is that of the lobe at its brightest.
//!
//! Numbers of a texel: d of each channel; for each lobe s of each channel, x, y, z, n.

use super::TexelNumbers;

/// The most lobes of a texel.
pub const MOST_LOBES: usize = 3;

/// The numbers of a texel of so many channels.
pub(super) fn count(channels: usize, lobes: usize) -> usize {
    channels + lobes * stride(channels)
}

/// The numbers of a lobe.
pub(super) fn stride(channels: usize) -> usize {
    channels + 4
}

/// The names of the numbers of a texel.
pub(super) fn names(channels: &[&str], lobes: usize) -> Vec<String> {
    let diffuse = channels.iter().map(|c| format!("diffuse.{c}"));
    let of_lobe = |k: usize| {
        let colors = channels.iter().map(move |c| format!("lobe{k}.{c}"));
        colors.chain(["x", "y", "z", "n"].map(|part| format!("lobe{k}.{part}")))
    };
    diffuse.chain((0..lobes).flat_map(of_lobe)).collect()
}

/// The radiance in each channel, for products (or components) weighted by x, y, z, and the cosine of the light.
pub(super) fn radiance(numbers: &TexelNumbers, products: [f64; 3], cosine: f64, out: &mut [f64]) {
    let channels = out.len();
    out.copy_from_slice(&numbers[..channels]);
    for lobe in numbers[channels..].chunks_exact(stride(channels)) {
        let (color, form) = lobe.split_at(channels);
        let sum = form[0] * products[0] + form[1] * products[1] + form[2] * products[2];
        if sum > 0.0 {
            let power = sum.powf(form[3]);
            out.iter_mut().zip(color).for_each(|(o, s)| *o += s * power);
        }
    }
    out.iter_mut().for_each(|o| *o *= cosine);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lobe_is_brightest_in_the_direction_of_its_weights() {
        // A mirror's lobe for a view 30 degrees to the right.
        let (sin, cos) = 0.5f64.sin_cos();
        let numbers = [0.1, 0.6, -1.0, -1.0, 1.0, 20.0];
        let value = |angle: f64| {
            let mut out = [0.0];
            let light = [angle.sin(), 0.0, angle.cos()];
            radiance(&numbers, [light[0] * sin, 0.0, light[2] * cos], 1.0, &mut out);
            out[0]
        };
        assert!((value(-0.5) - 0.7).abs() < 1e-12);
        assert!(value(-0.4) < value(-0.5) && value(-0.6) < value(-0.5));
        assert_eq!(value(1.5), 0.1);
    }
}
