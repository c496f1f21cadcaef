//! What readers remark on in files that they could read: values left out, converted or taken by convention.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use crate::clipping::{Clipper, Clipping};

/// Sentences and the files they concern, from any thread. Their order is that of the alphabet, so it does not
/// depend on the order of the work.
#[derive(Debug, Default)]
pub(crate) struct Remarks {
    said: Mutex<BTreeMap<String, BTreeSet<PathBuf>>>,
    clipped: Mutex<BTreeMap<(Clipper, Option<PathBuf>), Clipping>>,
}

impl Remarks {
    /// Keeps a sentence about a file; one that is said again of the same file is kept once.
    pub(crate) fn add(&self, sentence: String, file: Option<&Path>) {
        let mut all = self.said.lock().unwrap_or_else(PoisonError::into_inner);
        all.entry(sentence).or_default().extend(file.map(Path::to_path_buf));
    }

    /// Counts values that were clipped, to be said of all of a file together.
    pub(crate) fn count(&self, clipper: Clipper, clipping: Clipping, file: Option<&Path>) {
        let mut all = self.clipped.lock().unwrap_or_else(PoisonError::into_inner);
        let sum = all.entry((clipper, file.map(Path::to_path_buf))).or_default();
        *sum = sum.and(clipping);
    }

    /// All sentences, each once, with the first of the files it concerns and the number of the others.
    pub(crate) fn sentences(&self) -> Vec<String> {
        let mut all = self.said.lock().unwrap_or_else(PoisonError::into_inner).clone();
        for ((clipper, file), clipping) in &*self.clipped.lock().unwrap_or_else(PoisonError::into_inner) {
            let Some(sentence) = clipping.sentence(*clipper) else { continue };
            all.entry(sentence).or_default().extend(file.clone());
        }
        all.iter().map(|(sentence, files)| with_files(sentence, files)).collect()
    }
}

fn with_files(sentence: &str, files: &BTreeSet<PathBuf>) -> String {
    let Some(first) = files.first().map(|file| file.display()) else { return sentence.to_owned() };
    match files.len() - 1 {
        0 => format!("{first}: {sentence}"),
        1 => format!("{first} and one more file: {sentence}"),
        more => format!("{first} and {more} more files: {sentence}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sentence_is_said_once_for_all_its_files() {
        let remarks = Remarks::default();
        for file in ["b.png", "a.png", "b.png", "c.png"] {
            remarks.add("is dark".to_owned(), Some(Path::new(file)));
        }
        remarks.add("all is well".to_owned(), None);
        assert_eq!(remarks.sentences(), ["all is well", "a.png and 2 more files: is dark"]);
    }
}
