//! Vectors whose length comes from input: where the system does not give the memory, one sentence
//! comes back instead of an abort.

use crate::error::{Error, Result};

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
    fn what_the_system_does_not_give_is_said_in_words() {
        let error = zeros::<f32>("the picture", usize::MAX / 8).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::Limit);
        assert!(error.message().starts_with("the picture needs"), "{error}");
        assert_eq!(zeros::<u8>("a row", 3).unwrap(), [0; 3]);
    }
}
