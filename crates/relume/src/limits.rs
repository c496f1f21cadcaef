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
            return Err(self.refusal(what, bytes));
        }
        Ok(())
    }

    /// The error for `what`, which does not fit.
    pub(crate) fn refusal(&self, what: &str, bytes: u64) -> Error {
        Error::limit(format!(
            "{what} needs {} of memory and the limit is {}: choose a smaller size or raise the limit",
            megabytes(bytes),
            megabytes(self.max_bytes)
        ))
    }
}

fn megabytes(bytes: u64) -> String {
    format!("{:.1} MiB", bytes as f64 / (1u64 << 20) as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_that_overflow_are_refused_rather_than_wrapped() {
        let limits = Limits { max_bytes: u64::MAX - 1, max_side: usize::MAX };
        let size = Size { width: usize::MAX / 2, height: 2 };
        assert!(limits.check("a field", size, 1 << 40).is_err());
        assert!(Limits::default().check("a field", Size { width: 0, height: 3 }, 4).is_err());
        assert!(Limits::default().check("a field", Size { width: 3, height: 3 }, 4).is_ok());
    }
}
