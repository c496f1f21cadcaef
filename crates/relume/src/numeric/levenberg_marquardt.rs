//! Nonlinear least squares within bounds by the method of Levenberg and Marquardt (D. W. Marquardt, "An Algorithm for
//! Least-Squares Estimation of Nonlinear Parameters", Journal of the SIAM 11, 1963), for a few parameters and millions of
//! problems: one minimiser is used for many.
//!
//! A parameter at a bound that its gradient pushes against stays out of the step, and a step is cut off at the bounds
//! (the projected Newton method: D. P. Bertsekas, "Projected Newton Methods for Optimization Problems with Simple
//! Constraints", SIAM Journal on Control and Optimization 20, 1982).

/// The damping of the first step, its change after steps that succeed and fail, and the one at which there is no step left.
const FIRST: f64 = 1e-2;
const LESS: f64 = 0.2;
const MORE: f64 = 4.0;
const MOST: f64 = 1e8;

/// Damping that all parameters get, as a share of the largest entry of the matrix: those without an effect stay.
const FLOOR: f64 = 1e-10;

/// A step that lowers the sum of squares by less than this share is the last one.
const SETTLED: f64 = 1e-5;

/// J'J, J'r and r'r of residuals r with the derivatives J by the parameters.
#[derive(Debug, Clone)]
pub struct NormalEquations {
    parameters: usize,
    /// The lower triangle, in rows of all parameters.
    gram: Vec<f64>,
    gradient: Vec<f64>,
    squares: f64,
}

impl NormalEquations {
    fn new(parameters: usize) -> Self {
        let zeros = |n| vec![0.0; n];
        Self { parameters, gram: zeros(parameters * parameters), gradient: zeros(parameters), squares: 0.0 }
    }

    fn clear(&mut self) {
        self.gram.fill(0.0);
        self.gradient.fill(0.0);
        self.squares = 0.0;
    }

    /// Adds a residual, and its derivative by each parameter.
    pub fn add(&mut self, residual: f64, derivatives: &[f64]) {
        for (j, &a) in derivatives.iter().enumerate().filter(|(_, a)| **a != 0.0) {
            let row = &mut self.gram[j * self.parameters..][..=j];
            row.iter_mut().zip(derivatives).for_each(|(sum, b)| *sum += a * b);
            self.gradient[j] += a * residual;
        }
        self.squares += residual * residual;
    }
}

/// Minimises sums of squares of a number of parameters.
#[derive(Debug, Clone)]
pub struct LevenbergMarquardt {
    equations: NormalEquations,
    factor: Vec<f64>,
    step: Vec<f64>,
    moved: Vec<f64>,
    free: Vec<usize>,
}

impl LevenbergMarquardt {
    /// For problems of so many parameters.
    pub fn new(parameters: usize) -> Self {
        Self {
            equations: NormalEquations::new(parameters),
            factor: vec![0.0; parameters * parameters],
            step: vec![0.0; parameters],
            moved: vec![0.0; parameters],
            free: Vec::with_capacity(parameters),
        }
    }

    /// Moves parameters, from where they are within their bounds (least, most), to a local minimum of the sum of squares,
    /// in at most `steps` steps. `add` adds all residuals at some parameters; `squares` is their sum alone. Returns the sum
    /// reached, never more than that at the start.
    pub fn minimise(
        &mut self,
        parameters: &mut [f64],
        bounds: &[[f64; 2]],
        steps: usize,
        mut add: impl FnMut(&[f64], &mut NormalEquations),
        mut squares: impl FnMut(&[f64]) -> f64,
    ) -> f64 {
        let mut damping = FIRST;
        let mut reached = f64::INFINITY;
        for _ in 0..steps {
            self.equations.clear();
            add(parameters, &mut self.equations);
            reached = self.equations.squares;
            self.find_free(parameters, bounds);
            let lower = loop {
                if damping > MOST {
                    return reached;
                }
                if self.find_step(damping) {
                    for (k, moved) in self.moved.iter_mut().enumerate() {
                        *moved = (parameters[k] + self.step[k]).clamp(bounds[k][0], bounds[k][1]);
                    }
                    let lower = squares(&self.moved);
                    if lower < reached {
                        break lower;
                    }
                }
                damping *= MORE;
            };
            parameters.copy_from_slice(&self.moved);
            damping *= LESS;
            let gain = reached - lower;
            let is_settled = gain <= SETTLED * reached;
            reached = lower;
            if is_settled {
                break;
            }
        }
        reached
    }

    /// The parameters that no bound stops.
    fn find_free(&mut self, parameters: &[f64], bounds: &[[f64; 2]]) {
        let gradient = &self.equations.gradient;
        let is_stopped = |k: &usize| {
            let [least, most] = bounds[*k];
            (parameters[*k] <= least && gradient[*k] > 0.0) || (parameters[*k] >= most && gradient[*k] < 0.0)
        };
        self.free.clear();
        self.free.extend((0..parameters.len()).filter(|k| !is_stopped(k)));
    }

    /// The damped step of the free parameters; `false` where rounding leaves none.
    fn find_step(&mut self, damping: f64) -> bool {
        let (n, all) = (self.free.len(), self.equations.parameters);
        let Self { equations, factor, step, free, .. } = self;
        let entry = |i: usize, j: usize| equations.gram[free[i].max(free[j]) * all + free[i].min(free[j])];
        let largest = (0..n).map(|i| entry(i, i)).fold(0.0, f64::max);
        step.fill(0.0);
        // Cholesky's factor, and with it the solution.
        for i in 0..n {
            for j in 0..=i {
                let damped =
                    if i == j { entry(i, i) * (1.0 + damping) + FLOOR * largest } else { entry(i, j) };
                let rest = damped - (0..j).map(|k| factor[i * all + k] * factor[j * all + k]).sum::<f64>();
                if i > j {
                    factor[i * all + j] = rest / factor[j * all + j];
                } else if rest > 0.0 {
                    factor[i * all + i] = rest.sqrt();
                } else {
                    return false;
                }
            }
        }
        let mut solution: Vec<f64> = free.iter().map(|&k| -equations.gradient[k]).collect();
        for i in 0..n {
            let known: f64 = (0..i).map(|k| factor[i * all + k] * solution[k]).sum();
            solution[i] = (solution[i] - known) / factor[i * all + i];
        }
        for i in (0..n).rev() {
            let known: f64 = (i + 1..n).map(|k| factor[k * all + i] * solution[k]).sum();
            solution[i] = (solution[i] - known) / factor[i * all + i];
        }
        free.iter().zip(&solution).for_each(|(&k, s)| step[k] = *s);
        solution.iter().all(|s| s.is_finite())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// y = a exp(-b t) + c at some times.
    fn decay(truth: [f64; 3], bounds: [[f64; 2]; 3], start: [f64; 3]) -> ([f64; 3], f64) {
        let times: Vec<f64> = (0..40).map(|i| 0.1 * f64::from(i)).collect();
        let value = |p: &[f64], t: f64| p[0] * (-p[1] * t).exp() + p[2];
        let mut found = start;
        let residual = |p: &[f64], t: f64| value(p, t) - value(&truth, t);
        let reached = LevenbergMarquardt::new(3).minimise(
            &mut found,
            &bounds,
            60,
            |p, equations| {
                for &t in &times {
                    let e = (-p[1] * t).exp();
                    equations.add(residual(p, t), &[e, -p[0] * t * e, 1.0]);
                }
            },
            |p| times.iter().map(|&t| residual(p, t).powi(2)).sum(),
        );
        (found, reached)
    }

    #[test]
    fn parameters_without_error_are_found() {
        let (found, reached) = decay([2.0, 0.7, 0.3], [[-9.0, 9.0]; 3], [1.0, 3.0, 0.0]);
        assert!(reached < 1e-8, "{reached}");
        found.iter().zip([2.0, 0.7, 0.3]).for_each(|(a, b)| assert!((a - b).abs() < 1e-3, "{found:?}"));
    }

    #[test]
    fn parameters_stay_within_their_bounds() {
        // The truth is outside; the constant of the least error inside is on the bound.
        let (found, reached) = decay([2.0, 0.7, -0.3], [[0.0, 9.0], [0.0, 9.0], [0.0, 9.0]], [1.0, 1.0, 0.5]);
        assert_eq!(found[2], 0.0);
        assert!(reached > 1e-4 && found[1] > 0.7, "{found:?}");
        let (again, other) = decay([2.0, 0.7, -0.3], [[0.0, 9.0], [0.0, 9.0], [0.0, 0.0]], [3.0, 2.0, 0.0]);
        assert!((reached - other).abs() < 1e-4 * other, "{found:?} {again:?}");
    }

    #[test]
    fn a_parameter_without_effect_stays_and_the_minimum_is_kept() {
        let mut p = [0.5, 7.0];
        let reached = LevenbergMarquardt::new(2).minimise(
            &mut p,
            &[[0.0, 1.0], [0.0, 10.0]],
            20,
            |p, equations| equations.add(p[0] - 0.25, &[1.0, 0.0]),
            |p| (p[0] - 0.25).powi(2),
        );
        assert!(reached < 1e-12 && (p[0] - 0.25).abs() < 1e-6);
        assert_eq!(p[1], 7.0);
    }
}
