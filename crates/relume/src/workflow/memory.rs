//! The memory of whole jobs, from sizes alone, so that a job that cannot be completed is refused before
//! the work instead of after it.

use crate::error::Result;
use crate::format::FieldFormat;
use crate::job::Job;
use crate::memory::Footprint;
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
    /// What is needed to gather outputs of `size` texels by a source map, and to encode them: the map, the
    /// gathered planes, what encoding them takes, and the files encoded before. `outputs` are the formats of
    /// the textures written and their numbers of coefficient planes, in order.
    pub fn of_copies(size: Size, outputs: &[(FieldFormat, usize)]) -> Self {
        let stages = outputs.iter().map(|&(format, planes)| {
            let gathered = Footprint::of_texels(size, 4 * planes as u64, 4 * planes as u64);
            gathered.then(format.footprint(size, planes))
        });
        let map = Footprint::of_texels(size, size_of::<Texel>() as u64, size_of::<Texel>() as u64);
        Self::of_stages("writing the texture", std::iter::once(map).chain(stages))
    }

    /// That of stages one after another, each beside the results of all before.
    pub fn of_stages(stage: &'static str, stages: impl IntoIterator<Item = Footprint>) -> Self {
        let (mut kept, mut bytes) = (0u64, 0u64);
        for footprint in stages {
            bytes = bytes.max(kept.saturating_add(footprint.peak));
            kept = kept.saturating_add(footprint.kept);
        }
        Self { stage, bytes }
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
    use crate::format::{Depth, PictureFormat};
    use crate::limits::Limits;

    #[test]
    fn files_encoded_before_count_for_those_after() {
        let size = Size::new(10, 10);
        let (ptm, png) = ((FieldFormat::Ptm, 9), (FieldFormat::Picture(PictureFormat::Png(Depth::Eight)), 3));
        let bytes = |outputs: &[_]| MemoryPeak::of_copies(size, outputs).bytes;
        // A map of 12 bytes, nine planes of f32, and 36 bytes to encode them to 9.
        assert_eq!(bytes(&[ptm]), 100 * (12 + 36 + 36));
        // Three planes and their copy, and 15 bytes to encode these to 3.
        assert_eq!(bytes(&[png]), 100 * (12 + 12 + 12 + 15));
        assert_eq!(bytes(&[ptm, png]), 100 * (12 + 36 + 36));
        assert_eq!(bytes(&[png, ptm]), 100 * (12 + 3 + 36 + 36));
        assert_eq!(MemoryPeak::of_copies(Size::new(usize::MAX, 2), &[ptm]).bytes, u64::MAX);
    }

    #[test]
    fn a_peak_fits_beside_what_is_held_or_is_refused() {
        let job = Job::new(Limits { max_bytes: 20_000, ..Limits::default() });
        let peak = MemoryPeak { stage: "writing the texture", bytes: 15_000 };
        assert!(peak.check(&job).is_ok());
        let _exemplar = job.hold("the exemplar", 9_000).unwrap();
        assert!(
            peak.check(&job).unwrap_err().message().starts_with("with writing the texture, the job needs")
        );
    }
}
