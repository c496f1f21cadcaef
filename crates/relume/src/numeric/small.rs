//! Systems of a few equations, solved on the stack, for millions of texels.

/// The solution of A x = b for a symmetric positive definite A by Cholesky's method, reading only the lower
/// triangle; `None` where a pivot is below 1e-10 of the largest diagonal entry.
pub fn solve_spd<const N: usize>(a: &[[f64; N]; N], b: &[f64; N]) -> Option<[f64; N]> {
    let least = 1e-10 * (0..N).map(|i| a[i][i]).fold(0.0, f64::max);
    let mut l = [[0.0; N]; N];
    for j in 0..N {
        for i in j..N {
            let rest = a[i][j] - (0..j).map(|k| l[i][k] * l[j][k]).sum::<f64>();
            if i > j {
                l[i][j] = rest / l[j][j];
            } else if rest > least {
                l[j][j] = rest.sqrt();
            } else {
                return None;
            }
        }
    }
    let mut x = *b;
    for i in 0..N {
        x[i] = (x[i] - (0..i).map(|k| l[i][k] * x[k]).sum::<f64>()) / l[i][i];
    }
    for i in (0..N).rev() {
        x[i] = (x[i] - (i + 1..N).map(|k| l[k][i] * x[k]).sum::<f64>()) / l[i][i];
    }
    Some(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solutions_satisfy_their_equations_and_singular_systems_have_none() {
        let a = [[4.0, 1.0, -2.0, 0.5], [1.0, 3.0, 0.25, 0.0], [-2.0, 0.25, 5.0, 1.0], [0.5, 0.0, 1.0, 2.0]];
        let b = [1.0, -2.0, 3.0, 0.5];
        let x = solve_spd(&a, &b).unwrap();
        for (row, expected) in a.iter().zip(b) {
            let found: f64 = row.iter().zip(x).map(|(a, x)| a * x).sum();
            assert!((found - expected).abs() < 1e-12);
        }
        assert_eq!(solve_spd(&[[1.0, 1.0], [1.0, 1.0]], &[1.0, 1.0]), None);
        assert_eq!(solve_spd(&[[0.0]], &[1.0]), None);
        assert_eq!(solve_spd(&[[f64::NAN]], &[1.0]), None);
    }
}
