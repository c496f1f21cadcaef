//! Faults of the program itself become one sentence.

use std::panic::{self, PanicHookInfo, UnwindSafe};
use std::sync::{Mutex, PoisonError};

/// The latest panic of any thread, in words.
static LATEST: Mutex<Option<String>> = Mutex::new(None);

/// Silences panics from now on, unless RUST_BACKTRACE asks for more.
pub fn keep_quiet() {
    let loud = panic::take_hook();
    panic::set_hook(Box::new(move |info| {
        *LATEST.lock().unwrap_or_else(PoisonError::into_inner) = Some(sentence(info));
        if std::env::var_os("RUST_BACKTRACE").is_some_and(|value| value != "0") {
            loud(info);
        }
    }));
}

/// Runs some work; a panic in it, in any thread, becomes a sentence.
pub fn caught<T>(work: impl FnOnce() -> T + UnwindSafe) -> Result<T, String> {
    panic::catch_unwind(work).map_err(|_| {
        let latest = LATEST.lock().unwrap_or_else(PoisonError::into_inner).take();
        latest
            .unwrap_or_else(|| "this is a fault of relume: please report it with the command line".to_owned())
    })
}

fn sentence(info: &PanicHookInfo<'_>) -> String {
    let payload = info.payload();
    let owned = payload.downcast_ref::<String>().map(String::as_str);
    let message = payload.downcast_ref::<&str>().copied().or(owned).unwrap_or("a panic without words");
    let message = message.replace('\n', " ");
    let place = info.location().map(|at| format!(" at {}:{}", at.file(), at.line())).unwrap_or_default();
    format!("this is a fault of relume: {message}{place}; please report it with the command line")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_of_any_thread_becomes_one_sentence_with_its_place() {
        let loud = panic::take_hook();
        keep_quiet();
        let own = caught(|| panic!("two\nlines")).map(|()| 0);
        let other = caught(|| {
            use rayon::prelude::*;
            (0..100).into_par_iter().map(|i| [1, 2][i]).sum::<usize>()
        });
        panic::set_hook(loud);
        for (said, words) in [(own.unwrap_err(), "two lines"), (other.unwrap_err(), "out of bounds")] {
            assert!(said.starts_with("this is a fault of relume: ") && said.contains(words), "{said}");
            assert!(said.contains("fault.rs:") && said.lines().count() == 1, "{said}");
        }
        assert_eq!(caught(|| 3), Ok(3));
    }
}
