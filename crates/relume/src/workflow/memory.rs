//! The memory of whole jobs, from sizes alone, so that a job that cannot be completed is refused before
//! the work instead of after it.

use crate::error::Result;
use crate::job::Job;
use crate::size::Size;
use crate::synthesis::Texel;

/// The stage of a job that needs the most memory, beside the memory held when it is asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MemoryPeak {
    /// What the stage does, as the subject of a sentence.
    pub stage: &'static str,
    /// What it needs, in bytes.
    pub bytes: u64,
}

impl MemoryPeak {
    /// What is needed to gather an output of `size` texels by a source map, and to encode it: the map, the
    /// gathered planes, their stored values, and the files encoded before. `planes` are the numbers of
    /// coefficient planes of the textures written, in order.
    pub fn of_copies(size: Size, planes: &[usize]) -> Self {
        let texels = (size.width as u64).saturating_mul(size.height as u64);
        let mut encoded = 0;
        let mut most = 0;
        for planes in planes.iter().map(|&planes| planes as u64) {
            // Planes of f32, a copy of them, their codes and the file: four bytes each at most.
            most = most.max(size_of::<Texel>() as u64 + encoded + 16 * planes);
            encoded += 4 * planes;
        }
        Self { stage: "writing the texture", bytes: texels.saturating_mul(most) }
    }

    /// Refuses the job when this peak does not fit beside the memory held.
    ///
    /// # Errors
    /// [`ErrorKind::Limit`](crate::ErrorKind::Limit).
    pub fn check(self, job: &Job) -> Result<()> {
        job.check_bytes(self.stage, self.bytes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::limits::Limits;

    #[test]
    fn files_encoded_before_count_for_those_after() {
        let size = Size::new(10, 10);
        assert_eq!(MemoryPeak::of_copies(size, &[9]).bytes, 100 * (12 + 144));
        assert_eq!(MemoryPeak::of_copies(size, &[9, 3]).bytes, 100 * (12 + 144));
        assert_eq!(MemoryPeak::of_copies(size, &[3, 9]).bytes, 100 * (12 + 12 + 144));
        assert_eq!(MemoryPeak::of_copies(Size::new(usize::MAX, 2), &[9]).bytes, u64::MAX);
    }

    #[test]
    fn a_peak_fits_beside_what_is_held_or_is_refused() {
        let job = Job::new(Limits { max_bytes: 20_000, ..Limits::default() });
        let peak = MemoryPeak::of_copies(Size::new(10, 10), &[9]);
        assert!(peak.check(&job).is_ok());
        let _exemplar = job.hold("the exemplar", 9_000).unwrap();
        assert!(peak.check(&job).unwrap_err().message().starts_with("writing the texture needs"));
    }
}
