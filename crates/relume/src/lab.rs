//! CIE L*a*b* coordinates (ISO/CIE 11664-4:2019) of linear red, green and blue of ITU-R BT.709-6, white D65.

/// The coordinates of the white of red, green and blue: the row sums of the matrix.
const WHITE: [f64; 3] = [0.950_455_93, 1.0, 1.089_057_75];

/// From linear red, green and blue to X, Y, Z (IEC 61966-2-1:1999).
const XYZ: [[f64; 3]; 3] = [
    [0.412_390_80, 0.357_584_34, 0.180_480_79],
    [0.212_639_01, 0.715_168_68, 0.072_192_31],
    [0.019_330_82, 0.119_194_78, 0.950_532_15],
];

/// L*, a*, b* of a linear colour with white at 1; L* of white is 100.
pub fn from_linear(rgb: [f64; 3]) -> [f64; 3] {
    let [x, y, z] = std::array::from_fn(|i| {
        let value: f64 = XYZ[i].iter().zip(rgb).map(|(m, v)| m * v).sum();
        response(value / WHITE[i])
    });
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// The cube root, and the line that continues it below (6/29)^3.
fn response(t: f64) -> f64 {
    const KNEE: f64 = 6.0 / 29.0;
    if t > KNEE * KNEE * KNEE { t.cbrt() } else { t / (3.0 * KNEE * KNEE) + 4.0 / 29.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn white_grey_and_primaries_have_their_known_coordinates() {
        let near = |rgb, expected: [f64; 3]| {
            let found = from_linear(rgb);
            found.iter().zip(expected).for_each(|(a, b)| assert!((a - b).abs() < 0.02, "{found:?}"));
        };
        near([1.0; 3], [100.0, 0.0, 0.0]);
        near([0.0; 3], [0.0, 0.0, 0.0]);
        near([0.184_186_52; 3], [50.0, 0.0, 0.0]);
        near([1.0, 0.0, 0.0], [53.24, 80.09, 67.20]);
        near([0.0, 1.0, 0.0], [87.73, -86.18, 83.18]);
        near([0.0, 0.0, 1.0], [32.30, 79.19, -107.86]);
    }
}
