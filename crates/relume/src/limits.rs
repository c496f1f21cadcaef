//! Limits, checked before every allocation whose size comes from input.

use crate::error::{Error, Result};
use crate::size::Size;

/// How large a job may be. Readers and stages check before they allocate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limits {
    /// Bytes that the whole job may hold at a time.
    pub max_bytes: u64,
    /// Texels along either side of any image or field.
    pub max_side: usize,
}

impl Default for Limits {
    /// 4 GiB, and sides up to 131,072 texels.
    fn default() -> Self {
        Self { max_bytes: 4 << 30, max_side: 1 << 17 }
    }
}

impl Limits {
    /// Refuses `what` when `size` with `bytes_per_texel` does not fit, or a side is zero.
    pub fn check(&self, what: &str, size: Size, bytes_per_texel: u64) -> Result<()> {
        let Size { width, height } = size;
        if width == 0 || height == 0 {
            return Err(Error::invalid(format!(
                "{what} is {width} x {height} texels: both sides must be at least 1"
            )));
        }
        if width > self.max_side || height > self.max_side {
            return Err(Error::limit(format!(
                "{what} is {width} x {height} texels: the longest side allowed is {}",
                self.max_side
            )));
        }
        self.check_bytes(what, (width as u64 * height as u64).saturating_mul(bytes_per_texel))
    }

    /// Refuses `what` when it needs more than [`Limits::max_bytes`].
    pub fn check_bytes(&self, what: &str, bytes: u64) -> Result<()> {
        if bytes > self.max_bytes {
            return Err(self.refusal(what, bytes, 0));
        }
        Ok(())
    }

    /// The error for `what`, which does not fit beside the bytes `held`: a limit of the figure that it gives lets
    /// it pass.
    pub(crate) fn refusal(&self, what: &str, bytes: u64, held: u64) -> Error {
        Error::limit(format!(
            "with {what}, the job needs {} GiB of memory and the limit is {} GiB: choose a smaller size or raise the \
             limit",
            gibibytes(bytes.saturating_add(held).saturating_add(1), f64::ceil),
            gibibytes(self.max_bytes, f64::round)
        ))
    }
}

/// GiB in three significant digits.
fn gibibytes(bytes: u64, rounded: fn(f64) -> f64) -> String {
    let gib = bytes as f64 / (1u64 << 30) as f64;
    if gib == 0.0 {
        return "0".to_owned();
    }
    let decimals = (2 - gib.log10().floor() as i32).max(0);
    let scale = 10f64.powi(decimals);
    format!("{:.*}", decimals as usize, rounded(gib * scale) / scale)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_limit_raised_to_the_figure_of_a_refusal_lets_the_job_pass() {
        for (bytes, held) in [(1, 0), (300 << 20, 77 << 20), (5 << 30, 1), (1u64 << 40, 12345)] {
            let said = Limits { max_bytes: 0, ..Limits::default() }
                .refusal("a map", bytes, held)
                .message()
                .to_owned();
            let figure = said.split_once("needs ").unwrap().1.split_once(' ').unwrap().0;
            let raised = (figure.parse::<f64>().unwrap() * (1u64 << 30) as f64) as u64;
            assert!(raised >= bytes + held && raised as f64 <= 1.01 * (bytes + held) as f64 + 2.0, "{said}");
        }
    }

    #[test]
    fn sizes_that_overflow_are_refused_rather_than_wrapped() {
        let limits = Limits { max_bytes: u64::MAX - 1, max_side: usize::MAX };
        let size = Size { width: usize::MAX / 2, height: 2 };
        assert!(limits.check("a field", size, 1 << 40).is_err());
        assert!(Limits::default().check("a field", Size { width: 0, height: 3 }, 4).is_err());
        assert!(Limits::default().check("a field", Size { width: 3, height: 3 }, 4).is_ok());
    }
}
