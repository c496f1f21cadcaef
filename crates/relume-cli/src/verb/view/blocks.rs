//! Squares of endless planes, made when the page asks for them and kept while there is room.

use std::collections::VecDeque;
use std::sync::{Mutex, PoisonError};

use relume::{Job, Result};

use crate::viewer::ServedPlane;

/// The most bytes that are kept.
const MOST_BYTES: usize = 64 << 20;

/// An endless plane whose squares are made one after another.
#[derive(Debug)]
pub struct ServedBlocks {
    plane: ServedPlane,
    kept: Mutex<VecDeque<([i64; 2], Vec<u8>)>>,
}

impl ServedBlocks {
    /// The squares of a plane; none is made yet.
    pub fn new(plane: ServedPlane) -> Self {
        Self { plane, kept: Mutex::default() }
    }

    /// The file of a square by its column and row.
    ///
    /// # Errors
    /// Places too far away, memory, and a cancelled job.
    pub fn get(&self, place: [i64; 2], job: &Job) -> Result<Vec<u8>> {
        // One at a time: a square takes all threads.
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, bytes)) = kept.iter().find(|(other, _)| *other == place) {
            return Ok(bytes.clone());
        }
        let bytes = self.plane.block(place, job)?;
        kept.push_back((place, bytes.clone()));
        while kept.len() > 1 && kept.iter().map(|(_, bytes)| bytes.len()).sum::<usize>() > MOST_BYTES {
            kept.pop_front();
        }
        Ok(bytes)
    }
}
