//! Bayesian estimation of a causal autoregressive model, Y_r = gamma X_r + e_r with e ~ N(0, Sigma).
//!
//! Haindl, Filip, Arnold, "BTF Image Space Utmost Compression and Modelling Method" (2004), equations 3 to 7,
//! with the normal-Wishart prior given by V_0 and beta_0. There are two ways to the posterior: in closed form
//! from the inner products ([`Posterior::closed_form`]), and texel by texel ([`Recursive`]), which also
//! multiplies the Student-t predictives whose product is the evidence.
//!
//! The published statistic for choosing a model contains slips; this is the exact log evidence. With d
//! planes, q regressors, beta_0 = q + 1 (it must exceed q - 2), b_0 = beta_0 - q + d + 1 = d + 2 and b_n =
//! b_0 + n,
//!
//! ```text
//! ln p(Y) = -(d/2) ln(|V_xx| / |V_xx0|) - (b_n/2) ln|lambda| + (b_0/2) ln|lambda_0| - (n d/2) ln pi
//!           + sum_{i=1..d} [ ln Gamma((b_n + 1 - i)/2) - ln Gamma((b_0 + 1 - i)/2) ]
//! ```
//!
//! The published Sigma is lambda / beta_n, which with beta_0 = q + 1 shrinks as regressors are added. The
//! posterior mean, lambda / (b_n - d - 1) = lambda / (n + 1), does not, and is used here.

use crate::error::Result;
use crate::numeric::Matrix;

/// Inner products of d predicted planes and q regressors over n texels.
#[derive(Debug, Clone)]
pub struct SufficientStatistics {
    /// [Y; X][Y; X]', the d predicted planes first.
    pub products: Matrix,
    /// Predicted planes d.
    pub planes: usize,
    /// Texels n.
    pub texels: usize,
}

impl SufficientStatistics {
    /// The number of regressors q.
    pub fn regressors(&self) -> usize {
        self.products.rows() - self.planes
    }

    /// The statistics with only some of the regressors, in the given order.
    pub fn subset(&self, regressors: &[usize]) -> Self {
        let kept: Vec<usize> = (0..self.planes).chain(regressors.iter().map(|r| self.planes + r)).collect();
        let products = Matrix::from_fn(kept.len(), kept.len(), |a, b| self.products[(kept[a], kept[b])]);
        Self { products, ..*self }
    }

    /// The prior V_0 equivalent to `texels` texels of independent values of these mean squares: its diagonal;
    /// all else is zero. A regressor that is zero throughout keeps a trace, so that V_0 is invertible.
    pub fn prior(&self, texels: f64) -> Vec<f64> {
        let mean = |i: usize| self.products[(i, i)] / self.texels as f64;
        let largest = (0..self.products.rows()).map(mean).fold(0.0, f64::max);
        let trace = (1e-12 * largest).max(f64::MIN_POSITIVE);
        (0..self.products.rows()).map(|i| texels * mean(i).max(trace)).collect()
    }
}

/// The posterior of a model with given regressors.
#[derive(Debug, Clone)]
pub struct Posterior {
    /// gamma', q rows and d columns: the weight of each regressor in each predicted plane.
    pub weights: Matrix,
    /// lambda, d x d: the scatter of the prediction errors.
    pub scatter: Matrix,
    /// Texels n.
    pub texels: usize,
    /// ln p(Y), in nats.
    pub log_evidence: f64,
}

impl Posterior {
    /// gamma' = V_xx^-1 V_xy and lambda = V_yy - V_yx V_xx^-1 V_xy by Cholesky factors. `prior` is the
    /// diagonal of V_0, predicted planes first.
    ///
    /// # Errors
    /// When V is not positive definite.
    pub fn closed_form(statistics: &SufficientStatistics, prior: &[f64]) -> Result<Self> {
        let (d, q) = (statistics.planes, statistics.regressors());
        let v = |a: usize, b: usize| statistics.products[(a, b)] + if a == b { prior[a] } else { 0.0 };
        let factor = Matrix::from_fn(q, q, |a, b| v(d + a, d + b)).cholesky()?;
        let inverse = factor.lower_inverse();
        let half = inverse.times(&Matrix::from_fn(q, d, |a, j| v(d + a, j)));
        let explained = half.transposed().times(&half);
        let scatter = Matrix::from_fn(d, d, |i, j| v(i, j) - explained[(i, j)]);
        let evidence = Evidence {
            planes: d,
            texels: statistics.texels,
            log_determinant_ratio: log_determinant(&factor) - prior[d..].iter().map(|p| p.ln()).sum::<f64>(),
            log_scatter: log_determinant(&scatter.cholesky()?),
            log_prior_scatter: prior[..d].iter().map(|p| p.ln()).sum(),
        };
        Ok(Self {
            weights: inverse.transposed().times(&half),
            scatter,
            texels: statistics.texels,
            log_evidence: evidence.log(),
        })
    }

    /// The posterior mean of Sigma.
    pub fn noise_covariance(&self) -> Matrix {
        let d = self.scatter.rows();
        let scale = 1.0 / (self.texels as f64 + 1.0);
        Matrix::from_fn(d, d, |i, j| scale * self.scatter[(i, j)])
    }

    /// The prediction errors on other data: the sum over their texels of e e'.
    ///
    /// # Panics
    /// When the data have other planes or regressors.
    pub fn prediction_scatter(&self, data: &SufficientStatistics) -> Matrix {
        let (d, q) = (data.planes, data.regressors());
        assert_eq!((self.weights.rows(), self.weights.cols()), (q, d), "planes and regressors of the data");
        // e = [I, -gamma] [Y; X].
        let error = Matrix::from_fn(d, d + q, |i, a| {
            if a < d { f64::from(u8::from(i == a)) } else { -self.weights[(a - d, i)] }
        });
        error.times(&data.products).times(&error.transposed())
    }

    /// The Gaussian log likelihood of other data under the estimates, in nats.
    ///
    /// # Errors
    /// When the noise covariance is singular.
    pub fn log_likelihood(&self, data: &SufficientStatistics) -> Result<f64> {
        let d = data.planes;
        let factor = self.noise_covariance().cholesky()?;
        let inverse = factor.lower_inverse();
        let whitened = inverse.times(&self.prediction_scatter(data)).times(&inverse.transposed());
        let trace: f64 = (0..d).map(|i| whitened[(i, i)]).sum();
        let normaliser = d as f64 * std::f64::consts::TAU.ln() + log_determinant(&factor);
        Ok(-0.5 * (data.texels as f64 * normaliser + trace))
    }
}

/// ln of the determinant of L L'.
pub fn log_determinant(factor: &Matrix) -> f64 {
    (0..factor.rows()).map(|i| 2.0 * factor[(i, i)].ln()).sum()
}

/// The components of the log evidence.
#[derive(Debug, Clone, Copy)]
pub struct Evidence {
    /// Predicted planes d.
    pub planes: usize,
    /// Texels n.
    pub texels: usize,
    /// ln(|V_xx| / |V_xx0|).
    pub log_determinant_ratio: f64,
    /// ln|lambda|.
    pub log_scatter: f64,
    /// ln|lambda_0|.
    pub log_prior_scatter: f64,
}

impl Evidence {
    /// ln p(Y), in nats.
    pub fn log(&self) -> f64 {
        let (d, n) = (self.planes as f64, self.texels as f64);
        let (before, after) = (d + 2.0, d + 2.0 + n);
        let gammas: f64 = (0..self.planes)
            .map(|i| ln_gamma(0.5 * (after - i as f64)) - ln_gamma(0.5 * (before - i as f64)))
            .sum();
        -0.5 * d * self.log_determinant_ratio - 0.5 * after * self.log_scatter
            + 0.5 * before * self.log_prior_scatter
            - 0.5 * n * d * std::f64::consts::PI.ln()
            + gammas
    }
}

/// ln Gamma(x) for x > 0: the recurrence up to 16, then Stirling's series (Abramowitz and Stegun
/// 6.1.41) to x^-7.
pub fn ln_gamma(x: f64) -> f64 {
    let mut shift = 0.0;
    let mut x = x;
    while x < 16.0 {
        shift -= x.ln();
        x += 1.0;
    }
    let t = 1.0 / (x * x);
    let series = (1.0 / 12.0 - t * (1.0 / 360.0 - t * (1.0 / 1260.0 - t / 1680.0))) / x;
    shift + (x - 0.5) * x.ln() - x + 0.5 * std::f64::consts::TAU.ln() + series
}

/// The posterior, updated texel by texel: the slow truth of the closed form and of the evidence.
#[derive(Debug, Clone)]
pub struct Recursive {
    weights: Matrix,
    scatter: Matrix,
    /// V_xx^-1.
    inverse: Matrix,
    texels: usize,
    log_predictives: f64,
}

impl Recursive {
    /// The state before any texel; `prior` is the diagonal of V_0, the `planes` predicted planes first.
    pub fn new(planes: usize, prior: &[f64]) -> Self {
        let q = prior.len() - planes;
        let diagonal = |n: usize, f: &dyn Fn(usize) -> f64| {
            Matrix::from_fn(n, n, |a, b| if a == b { f(a) } else { 0.0 })
        };
        Self {
            weights: Matrix::zeros(q, planes),
            scatter: diagonal(planes, &|i| prior[i]),
            inverse: diagonal(q, &|a| 1.0 / prior[planes + a]),
            texels: 0,
            log_predictives: 0.0,
        }
    }

    /// Predicts a texel of value `y` from regressors `x`, and updates: gamma' += V_xx^-1 x e' / (1 + x'
    /// V_xx^-1 x), lambda += e e' / (1 + x' V_xx^-1 x).
    ///
    /// # Errors
    /// When lambda is no longer positive definite.
    pub fn observe(&mut self, y: &[f64], x: &[f64]) -> Result<()> {
        let (d, q) = (y.len(), x.len());
        let gain: Vec<f64> = (0..q).map(|a| (0..q).map(|b| self.inverse[(a, b)] * x[b]).sum()).collect();
        let spread = 1.0 + x.iter().zip(&gain).map(|(x, g)| x * g).sum::<f64>();
        let error: Vec<f64> =
            (0..d).map(|j| y[j] - (0..q).map(|a| self.weights[(a, j)] * x[a]).sum::<f64>()).collect();
        self.log_predictives += self.log_student_t(&error, spread)?;
        for a in 0..q {
            (0..d).for_each(|j| self.weights[(a, j)] += gain[a] * error[j] / spread);
            (0..q).for_each(|b| self.inverse[(a, b)] -= gain[a] * gain[b] / spread);
        }
        for i in 0..d {
            (0..d).for_each(|j| self.scatter[(i, j)] += error[i] * error[j] / spread);
        }
        self.texels += 1;
        Ok(())
    }

    /// The log density of a prediction error: a multivariate Student t with b + 1 - d degrees of freedom and
    /// the scale matrix `spread` lambda divided by that number.
    fn log_student_t(&self, error: &[f64], spread: f64) -> Result<f64> {
        let d = error.len() as f64;
        let b = d + 2.0 + self.texels as f64;
        let factor = self.scatter.cholesky()?;
        let whitened = factor.lower_inverse().times(&Matrix::from_fn(error.len(), 1, |i, _| error[i]));
        let square: f64 = (0..error.len()).map(|i| whitened[(i, 0)].powi(2)).sum();
        Ok(ln_gamma(0.5 * (b + 1.0))
            - ln_gamma(0.5 * (b + 1.0 - d))
            - 0.5 * d * (std::f64::consts::PI * spread).ln()
            - 0.5 * log_determinant(&factor)
            - 0.5 * (b + 1.0) * (square / spread).ln_1p())
    }

    /// The current posterior.
    pub fn posterior(self) -> Posterior {
        Posterior {
            weights: self.weights,
            scatter: self.scatter,
            texels: self.texels,
            log_evidence: self.log_predictives,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::random::{Purpose, Stream};
    use proptest::prelude::*;

    /// Random texels [y; x], with some dependence between them.
    fn texels(d: usize, q: usize, n: usize, seed: u64) -> Vec<Vec<f64>> {
        let mut stream = Stream::new(seed, Purpose::Sample, [0]);
        let mut texel = || {
            let mut values: Vec<f64> = (0..d + q).map(|_| stream.unit() - 0.45).collect();
            (1..d + q).for_each(|i| values[i] += 0.6 * values[i - 1]);
            values
        };
        (0..n).map(|_| texel()).collect()
    }

    fn statistics(d: usize, texels: &[Vec<f64>]) -> SufficientStatistics {
        let size = texels[0].len();
        let product = |a: usize, b: usize| texels.iter().map(|t| t[a] * t[b]).sum();
        SufficientStatistics {
            products: Matrix::from_fn(size, size, product),
            planes: d,
            texels: texels.len(),
        }
    }

    fn near(a: f64, b: f64) -> bool {
        (a - b).abs() < 1e-8 * (1.0 + a.abs().max(b.abs()))
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(60))]
        #[test]
        fn the_closed_form_equals_the_recursion_and_the_product_of_its_predictives(
            d in 1usize..5, q in 0usize..9, n in 1usize..60, worth in 0.05f64..3.0, seed: u64,
        ) {
            let texels = texels(d, q, n, seed);
            let statistics = statistics(d, &texels);
            let prior = statistics.prior(worth);
            let closed = Posterior::closed_form(&statistics, &prior).unwrap();
            let mut recursive = Recursive::new(d, &prior);
            texels.iter().for_each(|t| recursive.observe(&t[..d], &t[d..]).unwrap());
            let recursive = recursive.posterior();
            prop_assert!(near(closed.log_evidence, recursive.log_evidence), "{} {}", closed.log_evidence, recursive.log_evidence);
            for j in 0..d {
                (0..q).for_each(|a| assert!(near(closed.weights[(a, j)], recursive.weights[(a, j)])));
                (0..d).for_each(|i| assert!(near(closed.scatter[(i, j)], recursive.scatter[(i, j)])));
            }
        }

        #[test]
        fn the_likelihood_is_the_sum_of_gaussian_densities_of_one_step_predictions(
            d in 1usize..4, q in 0usize..5, n in 2usize..40, seed: u64,
        ) {
            let (train, test) = (texels(d, q, 30, seed), texels(d, q, n, seed ^ 1));
            let data = statistics(d, &train);
            let posterior = Posterior::closed_form(&data, &data.prior(1.0)).unwrap();
            let factor = posterior.noise_covariance().cholesky().unwrap();
            let inverse = factor.lower_inverse();
            let density = |t: &Vec<f64>| {
                let error = |j: usize| t[j] - (0..q).map(|a| posterior.weights[(a, j)] * t[d + a]).sum::<f64>();
                let square: f64 = (0..d).map(|i| (0..=i).map(|j| inverse[(i, j)] * error(j)).sum::<f64>().powi(2)).sum();
                -0.5 * (square + d as f64 * std::f64::consts::TAU.ln() + log_determinant(&factor))
            };
            let sum: f64 = test.iter().map(density).sum();
            prop_assert!(near(posterior.log_likelihood(&statistics(d, &test)).unwrap(), sum));
        }
    }

    #[test]
    fn ln_gamma_is_known_at_whole_and_half_numbers() {
        let mut factorial = 0.0;
        for n in 1..150 {
            assert!((ln_gamma(f64::from(n)) - factorial).abs() < 1e-12 * (1.0 + factorial), "{n}");
            factorial += f64::from(n).ln();
        }
        assert!((ln_gamma(0.5) - 0.5 * std::f64::consts::PI.ln()).abs() < 1e-13);
    }
}
