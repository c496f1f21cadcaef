//! The colour space that a picture file names, and the conversion of its colours to sRGB, the space of all
//! integer pictures here.
//!
//! ICC.1:2022 profiles of curves and a matrix, and the chunks of PNG, are applied; spaces near enough to sRGB
//! leave every code as it is. Profiles that describe colours by tables (printers, scanners) are not applied,
//! which is said. Profiles are parsed by `moxcms`; the arithmetic is here, since its results must not depend
//! on the instruction set.

mod png;
mod space;

pub(super) use png::tag_of_png;

use crate::format::meaning::Meaning;
use crate::job::Job;
use crate::raster::{Raster, Samples};
use space::ColorSpace;

/// What a file says of its colours.
pub(super) enum ColorTag {
    /// Nothing, or that they are sRGB.
    Silent,
    /// That they are of another space.
    Space(ColorSpace),
    /// Something that is not applied, for a reason.
    Unusable(String),
}

impl ColorTag {
    /// The tag of an ICC profile.
    pub(super) fn of_icc(profile: &[u8]) -> Self {
        match ColorSpace::of_icc(profile) {
            Ok(space) if space.is_near_srgb() => Self::Silent,
            Ok(space) => Self::Space(space),
            Err(reason) => Self::Unusable(reason),
        }
    }
}

/// The picture with its colours in sRGB where its values are colours. What is done, or is not, becomes a remark.
pub(super) fn in_srgb(raster: Raster, tag: &ColorTag, meaning: Meaning, job: &Job) -> Raster {
    match (meaning, tag) {
        (Meaning::Data, _) | (_, ColorTag::Silent) => raster,
        (_, ColorTag::Unusable(reason)) => {
            job.remark(format!(
                "its colour profile is not applied, because {reason}: its colours are taken as sRGB"
            ));
            raster
        }
        (Meaning::Copies, ColorTag::Space(space)) => {
            job.remark(format!(
                "its values are copied as stored, and its colour profile '{}' is left out: if they are colours, \
                 convert it to sRGB first",
                space.name()
            ));
            raster
        }
        (Meaning::Colors, ColorTag::Space(space)) if matches!(raster.samples(), Samples::F32(_)) => {
            job.remark(format!(
                "its colour profile '{}' is not applied to floats, which are taken as linear with the primaries of \
                 sRGB",
                space.name()
            ));
            raster
        }
        (Meaning::Colors, ColorTag::Space(space)) => {
            job.remark(format!("its colours are converted from '{}' to sRGB", space.name()));
            converted(&raster, space)
        }
    }
}

fn converted(raster: &Raster, space: &ColorSpace) -> Raster {
    let channels = raster.channels();
    let samples = match raster.samples() {
        Samples::U8(codes) => Samples::U8(space.convert(codes, channels, 255)),
        Samples::U16(codes) => Samples::U16(space.convert(codes, channels, 65535)),
        Samples::F32(values) => Samples::F32(values.clone()),
    };
    let picture = Raster::new(raster.size(), channels, samples).expect("as many samples as before");
    match raster.opacity() {
        Some(opacity) => picture.with_opacity(opacity.clone()).expect("as many texels as before"),
        None => picture,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::size::Size;

    #[test]
    fn a_damaged_profile_is_one_remark_and_leaves_the_codes() {
        let tag = ColorTag::of_icc(b"no profile");
        let raster = || Raster::new(Size::new(1, 1), 3, Samples::U8(vec![1, 2, 3])).unwrap();
        for (meaning, remarks) in [(Meaning::Colors, 1), (Meaning::Copies, 1), (Meaning::Data, 0)] {
            let job = Job::default();
            assert_eq!(in_srgb(raster(), &tag, meaning, &job), raster());
            assert_eq!(job.remarks().len(), remarks, "{meaning:?}");
        }
    }
}
