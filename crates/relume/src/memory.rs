//! Memory whose amount comes from input: what a stage takes, known from sizes alone, and vectors for which
//! one sentence comes back instead of an abort where the system does not give the memory.

use crate::error::{Error, Result};
use crate::size::Size;

/// The memory of a stage in bytes, beside that of its inputs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Footprint {
    /// The most at a time, the result included.
    pub peak: u64,
    /// The result, which stays.
    pub kept: u64,
}

impl Footprint {
    /// That of `size` texels of which each takes `peak` bytes, and its result `kept`.
    pub fn of_texels(size: Size, peak: u64, kept: u64) -> Self {
        let texels = (size.width as u64).saturating_mul(size.height as u64);
        Self { peak: texels.saturating_mul(peak), kept: texels.saturating_mul(kept) }
    }

    /// That of this stage and of another that takes its result and drops it.
    #[must_use]
    pub fn then(self, next: Self) -> Self {
        Self { peak: self.peak.max(self.kept.saturating_add(next.peak)), kept: next.kept }
    }
}

/// An empty vector with room for `length` values; `what` names them in the message.
///
/// # Errors
/// [`ErrorKind::Limit`](crate::ErrorKind::Limit) when the system does not give the memory.
pub(crate) fn with_capacity<T>(what: &str, length: usize) -> Result<Vec<T>> {
    let mut values = Vec::new();
    values.try_reserve_exact(length).map_err(|_| {
        let bytes = length as f64 * size_of::<T>() as f64 / f64::from(1 << 20);
        Error::limit(format!(
            "{what} needs {bytes:.1} MiB of memory, which the system does not give: choose a smaller size \
             or free memory"
        ))
    })?;
    Ok(values)
}

/// `length` zeros; `what` names them in the message.
///
/// # Errors
/// As [`with_capacity`].
pub(crate) fn zeros<T: Clone + Default>(what: &str, length: usize) -> Result<Vec<T>> {
    // Asked for and given back: pages that the system zeroes itself are faster than those filled here.
    drop(std::hint::black_box(with_capacity::<T>(what, length)?));
    Ok(vec![T::default(); length])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::ErrorKind;

    #[test]
    fn a_stage_that_takes_the_result_of_another_runs_beside_it() {
        let (made, written) = (Footprint { peak: 100, kept: 40 }, Footprint { peak: 70, kept: 30 });
        assert_eq!(made.then(written), Footprint { peak: 110, kept: 30 });
        assert_eq!(Footprint::of_texels(Size::new(usize::MAX, 2), 3, 1).peak, u64::MAX);
    }

    #[test]
    fn what_the_system_does_not_give_is_said_in_words() {
        let error = zeros::<f32>("the picture", usize::MAX / 8).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::Limit);
        assert!(error.message().starts_with("the picture needs"), "{error}");
        assert_eq!(zeros::<u8>("a row", 3).unwrap(), [0; 3]);
    }
}
