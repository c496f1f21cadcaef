//! Selection of the neighbours of a model by its evidence.
//!
//! The inner products of all candidates form one matrix V, with a block of d rows for the texel itself and
//! one for each candidate neighbour. Sweeping a block (Goodnight, "A Tutorial on the SWEEP Operator", The
//! American Statistician 33, 1979) makes its neighbour a regressor; sweeping it again removes it. At any time
//! the block of the texel itself is lambda, the swept blocks beside it are gamma, and the effect of a further
//! neighbour is a matter of d x d matrices:
//!
//! ```text
//! lambda' = A_yy - A_yc A_cc^-1 A_cy,    ln|V_xx'| = ln|V_xx| + ln|A_cc|   (or + ln|-A_cc| taking back)
//! ```

use super::normal_wishart::{Evidence, Posterior, SufficientStatistics, log_determinant};
use crate::error::{Error, Result};
use crate::job::Job;
use crate::names::named;
use crate::numeric::Matrix;
use crate::parallel;

/// Rows of a matrix that one thread sweeps together.
const ROWS_TOGETHER: usize = 64;

/// The order in which neighbourhoods are compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum SelectionOrder {
    /// The first candidates in their order, for each number of them.
    Nested,
    /// From none, adding the candidate that increases the evidence most, as long as it increases.
    Forward,
    /// From all, removing the candidate whose removal increases the evidence most, as long as it increases.
    Backward,
}

named!(SelectionOrder { Nested => "nested", Forward => "forward", Backward => "backward" });

/// A set of candidates and its probability.
#[derive(Debug, Clone, PartialEq)]
pub struct Selected {
    /// Candidates by number, in the order in which they were added.
    pub candidates: Vec<usize>,
    /// ln p(Y | candidates), in nats.
    pub log_evidence: f64,
    /// The same plus the log prior probability of the set. Nested sets are equally probable; for freely
    /// chosen sets all sizes are, and within a size all sets (Scott and Berger, "Bayes and Empirical-Bayes
    /// Multiplicity Adjustment", Annals of Statistics 38, 2010), which prevents a search among many
    /// candidates from finding spurious ones.
    pub log_posterior: f64,
}

/// The sets examined, from the most to the least probable. The empty set is always among them.
///
/// # Errors
/// When the inner products are not those of finite, linearly independent regressors.
pub fn search(
    statistics: &SufficientStatistics,
    prior: &[f64],
    how: SelectionOrder,
    most: usize,
    job: &Job,
) -> Result<Vec<Selected>> {
    let candidates = statistics.regressors() / statistics.planes;
    let mut sweep = CandidateSweep::new(statistics, prior);
    let mut path = vec![sweep.choice(how)?];
    match how {
        SelectionOrder::Nested => {
            for c in 0..candidates.min(most) {
                sweep.toggle(c)?;
                path.push(sweep.choice(how)?);
            }
        }
        SelectionOrder::Forward => greedy(&mut sweep, &mut path, how, most, job)?,
        SelectionOrder::Backward => {
            (0..candidates).try_for_each(|c| sweep.toggle(c))?;
            path.push(sweep.choice(how)?);
            greedy(&mut sweep, &mut path, how, most, job)?;
            path.retain(|choice| choice.candidates.len() <= most);
        }
    }
    path.sort_by(|a, b| b.log_posterior.total_cmp(&a.log_posterior));
    Ok(path)
}

/// Toggles the best candidate as long as the last set on the path becomes more probable or is larger than
/// allowed.
fn greedy(
    sweep: &mut CandidateSweep,
    path: &mut Vec<Selected>,
    how: SelectionOrder,
    most: usize,
    job: &Job,
) -> Result<()> {
    loop {
        job.proceed()?;
        let current = path[path.len() - 1].log_posterior;
        let (size, adding) = (sweep.inside.len(), how == SelectionOrder::Forward);
        if (adding && size >= most) || (!adding && size == 0) {
            return Ok(());
        }
        let open: Vec<usize> =
            (0..sweep.candidates()).filter(|c| sweep.inside.contains(c) != adding).collect();
        let evidences = parallel::try_map(open.iter(), |&c| sweep.evidence_after(c))?;
        let best = (0..open.len()).max_by(|&a, &b| evidences[a].total_cmp(&evidences[b]).then(b.cmp(&a)));
        let Some(best) = best else { return Ok(()) };
        let next = if adding { size + 1 } else { size - 1 };
        let posterior = evidences[best] + log_prior(how, sweep.candidates(), next);
        if posterior <= current && (adding || size <= most) {
            return Ok(());
        }
        sweep.toggle(open[best])?;
        path.push(sweep.choice(how)?);
    }
}

/// ln of the prior probability of one set of `size` out of `candidates`, up to a constant.
fn log_prior(how: SelectionOrder, candidates: usize, size: usize) -> f64 {
    match how {
        SelectionOrder::Nested => 0.0,
        // 1 / binomial(candidates, size).
        _ => (0..size).map(|i| ((i + 1) as f64 / (candidates - i) as f64).ln()).sum(),
    }
}

/// The posterior of a set of candidates.
///
/// # Errors
/// As [`search`].
pub fn posterior(
    statistics: &SufficientStatistics,
    prior: &[f64],
    candidates: &[usize],
) -> Result<Posterior> {
    let d = statistics.planes;
    let regressors: Vec<usize> = candidates.iter().flat_map(|c| d * c..d * (c + 1)).collect();
    let prior: Vec<f64> = prior[..d].iter().copied().chain(regressors.iter().map(|r| prior[d + r])).collect();
    let mut sweep = CandidateSweep::new(&statistics.subset(&regressors), &prior);
    (0..candidates.len()).try_for_each(|c| sweep.toggle(c))?;
    Ok(Posterior {
        weights: Matrix::from_fn(regressors.len(), d, |r, j| sweep.a[(d + r) * sweep.n + j]),
        scatter: sweep.block(0, 0),
        texels: statistics.texels,
        log_evidence: sweep.choice(SelectionOrder::Nested)?.log_evidence,
    })
}

/// V with some blocks swept.
struct CandidateSweep {
    n: usize,
    d: usize,
    texels: usize,
    /// Row by row.
    a: Vec<f64>,
    /// The swept candidates in order.
    inside: Vec<usize>,
    /// ln(|V_xx| / |V_xx0|) of the swept ones.
    log_determinant_ratio: f64,
    /// ln|V_xx0| of each candidate alone.
    log_prior: Vec<f64>,
    log_prior_scatter: f64,
}

impl CandidateSweep {
    fn new(statistics: &SufficientStatistics, prior: &[f64]) -> Self {
        let (n, d) = (statistics.products.rows(), statistics.planes);
        let mut a: Vec<f64> = (0..n).flat_map(|r| statistics.products.row(r).iter().copied()).collect();
        (0..n).for_each(|i| a[i * n + i] += prior[i]);
        let logs: Vec<f64> = prior.chunks(d).map(|block| block.iter().map(|p| p.ln()).sum()).collect();
        Self {
            n,
            d,
            texels: statistics.texels,
            a,
            inside: Vec::new(),
            log_determinant_ratio: 0.0,
            log_prior: logs[1..].to_vec(),
            log_prior_scatter: logs[0],
        }
    }

    fn candidates(&self) -> usize {
        self.log_prior.len()
    }

    /// Block (r, c) of d x d entries.
    fn block(&self, r: usize, c: usize) -> Matrix {
        Matrix::from_fn(self.d, self.d, |i, j| self.a[(r * self.d + i) * self.n + c * self.d + j])
    }

    /// The factor of the pivot block of a candidate, and whether it is already inside.
    fn pivot(&self, candidate: usize) -> Result<(Matrix, bool)> {
        let inside = self.inside.contains(&candidate);
        let (block, sign) = (self.block(candidate + 1, candidate + 1), if inside { -1.0 } else { 1.0 });
        let factor = Matrix::from_fn(self.d, self.d, |i, j| sign * block[(i, j)]).cholesky();
        factor.map(|factor| (factor, inside)).map_err(|_| singular())
    }

    /// The change of ln(|V_xx| / |V_xx0|) when a candidate with that pivot is toggled.
    fn log_ratio_change(&self, candidate: usize, factor: &Matrix, inside: bool) -> f64 {
        let prior = self.log_prior[candidate];
        log_determinant(factor) + if inside { prior } else { -prior }
    }

    fn evidence(&self, scatter: &Matrix, log_determinant_ratio: f64) -> Result<f64> {
        let log_scatter = log_determinant(&scatter.cholesky().map_err(|_| singular())?);
        let (planes, texels) = (self.d, self.texels);
        let log_prior_scatter = self.log_prior_scatter;
        Ok(Evidence { planes, texels, log_determinant_ratio, log_scatter, log_prior_scatter }.log())
    }

    /// The log evidence with one candidate more, or less if it is inside.
    fn evidence_after(&self, candidate: usize) -> Result<f64> {
        let (factor, inside) = self.pivot(candidate)?;
        let half = factor.lower_inverse().times(&self.block(candidate + 1, 0));
        let change = half.transposed().times(&half);
        let (scatter, sign) = (self.block(0, 0), if inside { 1.0 } else { -1.0 });
        let scatter = Matrix::from_fn(self.d, self.d, |i, j| scatter[(i, j)] + sign * change[(i, j)]);
        self.evidence(
            &scatter,
            self.log_determinant_ratio + self.log_ratio_change(candidate, &factor, inside),
        )
    }

    fn choice(&self, how: SelectionOrder) -> Result<Selected> {
        let log_evidence = self.evidence(&self.block(0, 0), self.log_determinant_ratio)?;
        let log_posterior = log_evidence + log_prior(how, self.candidates(), self.inside.len());
        Ok(Selected { candidates: self.inside.clone(), log_evidence, log_posterior })
    }

    /// Makes a candidate a regressor, or removes it.
    fn toggle(&mut self, candidate: usize) -> Result<()> {
        let (factor, inside) = self.pivot(candidate)?;
        self.log_determinant_ratio += self.log_ratio_change(candidate, &factor, inside);
        let sign = if inside { -1.0 } else { 1.0 };
        let root = factor.lower_inverse();
        let inverse = root.transposed().times(&root);
        self.eliminate((candidate + 1) * self.d, &inverse, sign);
        match inside {
            true => self.inside.retain(|&c| c != candidate),
            false => self.inside.push(candidate),
        }
        Ok(())
    }

    /// The sweep of the d rows from `first` on, whose pivot block is `sign` times the inverse of
    /// `inverse`.
    fn eliminate(&mut self, first: usize, inverse: &Matrix, sign: f64) {
        let (n, d) = (self.n, self.d);
        let pivot_rows = self.a[first * n..(first + d) * n].to_vec();
        // B = A_oc P^-1 for each other row o, and A_oo -= B A_co.
        let update = |row: &mut [f64]| {
            let column: Vec<f64> = row[first..first + d].to_vec();
            let b: Vec<f64> =
                (0..d).map(|j| sign * (0..d).map(|i| column[i] * inverse[(i, j)]).sum::<f64>()).collect();
            for (j, pivot_row) in pivot_rows.chunks_exact(n).enumerate() {
                row.iter_mut().zip(pivot_row).for_each(|(v, p)| *v -= b[j] * p);
            }
            // Adding a regressor keeps the sign of A_oc P^-1, removing it reverses it.
            (0..d).for_each(|j| row[first + j] = sign * b[j]);
        };
        let rows = self.a.chunks_mut(ROWS_TOGETHER * n).enumerate();
        parallel::for_each(rows, |(part, rows)| {
            let rows = (part * ROWS_TOGETHER..).zip(rows.chunks_exact_mut(n));
            rows.filter(|(r, _)| !(first..first + d).contains(r)).for_each(|(_, row)| update(row));
        });
        self.mirror(first);
        for i in 0..d {
            (0..d).for_each(|j| self.a[(first + i) * n + first + j] = -sign * inverse[(i, j)]);
        }
    }

    /// Copies the columns of the swept block to its rows: the matrix stays symmetric.
    fn mirror(&mut self, first: usize) {
        for i in first..first + self.d {
            (0..self.n).for_each(|o| self.a[i * self.n + o] = self.a[o * self.n + i]);
        }
    }
}

fn singular() -> Error {
    Error::invalid(
        "the statistics of these planes are singular: a plane that is constant or a copy of another has to be \
         left out",
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::random::{Purpose, Stream};
    use proptest::prelude::*;

    /// Statistics of random values in which the texel depends on candidates 1 and 3.
    fn statistics(d: usize, candidates: usize, n: usize, seed: u64) -> SufficientStatistics {
        let mut stream = Stream::new(seed, Purpose::Sample, [0]);
        let size = d * (candidates + 1);
        let mut products = Matrix::zeros(size, size);
        for _ in 0..n {
            let mut t: Vec<f64> = (0..size).map(|_| stream.unit() - 0.5).collect();
            for c in [1, 3].into_iter().filter(|&c| c < candidates) {
                (0..d).for_each(|j| t[j] += 0.7 * t[d * (c + 1) + (j + c) % d]);
            }
            for a in 0..size {
                (0..size).for_each(|b| products[(a, b)] += t[a] * t[b]);
            }
        }
        SufficientStatistics { products, planes: d, texels: n }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(40))]
        #[test]
        fn every_set_on_a_path_has_the_evidence_of_its_closed_form(
            d in 1usize..4, candidates in 1usize..7, n in 30usize..90, seed: u64,
        ) {
            let statistics = statistics(d, candidates, n, seed);
            let prior = statistics.prior(1.0);
            for how in [SelectionOrder::Nested, SelectionOrder::Forward, SelectionOrder::Backward] {
                for choice in search(&statistics, &prior, how, candidates, &Job::default()).unwrap() {
                    let swept = posterior(&statistics, &prior, &choice.candidates).unwrap();
                    let regressors: Vec<usize> = choice.candidates.iter().flat_map(|c| d * c..d * (c + 1)).collect();
                    let some: Vec<f64> = prior[..d].iter().copied().chain(regressors.iter().map(|r| prior[d + r])).collect();
                    let closed = Posterior::closed_form(&statistics.subset(&regressors), &some).unwrap();
                    let near = |a: f64, b: f64| (a - b).abs() < 1e-8 * (1.0 + a.abs());
                    prop_assert!(near(choice.log_evidence, closed.log_evidence), "{how:?} {choice:?} {}", closed.log_evidence);
                    prop_assert!(near(swept.log_evidence, closed.log_evidence));
                    for j in 0..d {
                        (0..regressors.len()).for_each(|r| assert!(near(swept.weights[(r, j)], closed.weights[(r, j)])));
                        (0..d).for_each(|i| assert!(near(swept.scatter[(i, j)], closed.scatter[(i, j)])));
                    }
                }
            }
        }
    }

    #[test]
    fn both_greedy_searches_find_what_the_texel_depends_on() {
        let statistics = statistics(2, 12, 2000, 5);
        let prior = statistics.prior(1.0);
        for how in [SelectionOrder::Forward, SelectionOrder::Backward] {
            let path = search(&statistics, &prior, how, 12, &Job::default()).unwrap();
            let mut best = path[0].candidates.clone();
            best.sort_unstable();
            assert_eq!(best, [1, 3], "{how:?}");
            assert!(path.iter().any(|choice| choice.candidates.is_empty()) || how == SelectionOrder::Forward);
        }
        let nested = search(&statistics, &prior, SelectionOrder::Nested, 12, &Job::default()).unwrap();
        assert_eq!(nested[0].candidates, [0, 1, 2, 3]);
    }

    #[test]
    fn the_number_of_neighbours_is_bounded() {
        let statistics = statistics(1, 8, 500, 2);
        let prior = statistics.prior(1.0);
        for how in [SelectionOrder::Nested, SelectionOrder::Forward, SelectionOrder::Backward] {
            let path = search(&statistics, &prior, how, 1, &Job::default()).unwrap();
            assert!(path.iter().all(|choice| choice.candidates.len() <= 1), "{how:?}");
        }
    }

    #[test]
    fn statistics_that_are_not_numbers_are_refused() {
        let mut statistics = statistics(1, 3, 50, 2);
        statistics.products[(2, 2)] = f64::NAN;
        let prior = vec![1.0; 4];
        assert!(search(&statistics, &prior, SelectionOrder::Nested, 3, &Job::default()).is_err());
    }
}
