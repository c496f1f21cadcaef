//! A fitted texture under lights whose photographs took no part in the fit.
//!
//! The texture is relit under each light and compared with the photograph as displays show both: sRGB-encoded 8-bit
//! values, whatever the space of the fit. The mean over pictures of the peak signal-to-noise ratio is the figure by
//! which the benchmarks SynthRTI and RealRTI compare (Dulecha, Fanni, Ponchio, Pellacini, Giachetti, "Neural reflectance
//! transformation imaging", The Visual Computer 36, 2020).

use serde::Serialize;

use crate::direction::Directions;
use crate::error::{Error, Result};
use crate::field::{Basis, ReflectanceField};
use crate::job::Job;
use crate::lamps::LampPositions;
use crate::numeric::decibel::{mean_psnr_db, psnr_db};
use crate::picture::Picture;
use crate::raster::{LoadRaster, Raster, Samples};
use crate::render::Relighter;
use crate::size::Size;
use crate::space::Space;

/// Photographs with which a texture is compared.
#[derive(Clone)]
pub struct ComparedPhotographs<'a> {
    /// The name and directions of each.
    pub pairs: &'a [(String, Directions)],
    /// Reads one by its number.
    pub load: &'a LoadRaster<'a>,
    /// Their lamps, where the light of each texel has a direction of its own; not for photographs that are interpolated.
    pub lamps: Option<&'a LampPositions>,
    /// The texels that are compared; all without a mask.
    pub mask: Option<&'a [bool]>,
    /// They are those of the fit, in its order: a field that interpolates between them, and so shows each as it is, is compared
    /// by what the others give under its light.
    pub are_fitted: bool,
    /// The numbers of those of the fit that have no part in what the others give, since they look wrong.
    pub set_aside: Vec<usize>,
}

/// How a texture does under lights that were not fitted.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct TestReport {
    /// The mean over pictures that have an error, in dB; infinite (in JSON: null) where none has one.
    pub psnr_db: f64,
    /// The number of pictures without an error, which the mean leaves out.
    pub exact: usize,
    /// The texels compared in each picture.
    pub texels: usize,
    /// The index in `lights` of the worst picture, the first of equals.
    pub worst: usize,
    /// Each picture, in the order given.
    pub lights: Vec<TestedLight>,
}

/// One picture of a test.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TestedLight {
    /// The name of the photograph.
    pub name: String,
    /// The unit vector towards the light.
    pub direction: [f64; 3],
    /// The peak signal-to-noise ratio of all values of the picture, in dB; infinite (in JSON: null) without an error.
    pub psnr_db: f64,
}

/// Relights a texture under the lights of photographs and compares.
///
/// # Errors
/// No photograph, photographs or a mask of another size, channels without a colour, and errors of the reader.
pub fn test(
    field: &ReflectanceField,
    photographs: &ComparedPhotographs<'_>,
    job: &Job,
) -> Result<TestReport> {
    let texels = photographs.texels(field.size());
    let mut lights = Vec::with_capacity(photographs.pairs.len());
    photographs.for_each(field, job, |i, relit, photograph| {
        let (name, pair) = &photographs.pairs[i];
        lights.push(TestedLight {
            name: name.clone(),
            direction: pair.light.to_array(),
            psnr_db: psnr_db(mean_square(relit, photograph, texels)),
        });
    })?;
    let worst = (0..lights.len()).fold(0, |w, i| if lights[i].psnr_db < lights[w].psnr_db { i } else { w });
    let (psnr_db, exact) = mean_psnr_db(lights.iter().map(|light| light.psnr_db));
    Ok(TestReport { psnr_db, exact, texels, worst, lights })
}

impl ComparedPhotographs<'_> {
    /// The number of texels compared of pictures of a size.
    pub(super) fn texels(&self, size: Size) -> usize {
        self.mask.map_or(size.texels(), |mask| mask.iter().filter(|inside| **inside).count())
    }

    /// Passes the codes of each relit picture and of its photograph, three a texel and black outside the mask, with the number of
    /// the photograph to `take`.
    ///
    /// # Errors
    /// No photograph, photographs or a mask of another size, channels without a colour, and errors of the reader.
    pub(super) fn for_each(
        &self,
        field: &ReflectanceField,
        job: &Job,
        mut take: impl FnMut(usize, &[u8], &[u8]),
    ) -> Result<()> {
        self.check(field)?;
        let bytes = 3 * field.size().texels();
        // A near lamp, and shapes, also need their values in three channels.
        job.check_bytes("the relit picture and the photograph", 9 * bytes as u64)?;
        let relighter = Relighter::new(field, job)?;
        let mut relit = vec![0u8; bytes];
        for (i, (name, pair)) in self.pairs.iter().enumerate() {
            job.proceed()?;
            let photograph = (self.load)(i)?;
            if photograph.size() != field.size() {
                return Err(Error::invalid(format!(
                    "the photograph {name} to compare with is {} texels and the texture {}: both must have the same size",
                    photograph.size(),
                    field.size()
                )));
            }
            match (self.lamps, self.weights_of_others(field, i)) {
                (Some(lamps), _) => relighter.relight_near_srgb8(lamps, i, &mut relit),
                (None, Some(weights)) => relighter.relight_srgb8_by(&weights, &mut relit),
                (None, None) => relighter.relight_srgb8(*pair, &mut relit),
            }
            let mut photograph = codes(&photograph);
            if let Some(mask) = self.mask {
                blacken(&mut relit, mask);
                blacken(&mut photograph, mask);
            }
            take(i, &relit, &photograph);
        }
        Ok(())
    }

    /// The field as it is compared with photograph `i`.
    pub fn relit(&self, field: &ReflectanceField, relighter: &Relighter<'_>, i: usize) -> Picture {
        match (self.lamps, self.weights_of_others(field, i)) {
            (Some(lamps), _) => relighter.relight_near(lamps, i),
            (None, Some(weights)) => relighter.relight_by(&weights),
            (None, None) => relighter.relight(self.pairs[i].1),
        }
    }

    /// Where a field interpolates between these photographs, the weights of all under the light of photograph `i`, which has none,
    /// as those that are set aside.
    fn weights_of_others(&self, field: &ReflectanceField, i: usize) -> Option<Vec<f64>> {
        let Basis::Interpolated(table) = field.basis() else { return None };
        if !self.are_fitted || table.lights().len() != self.pairs.len() {
            return None;
        }
        let counts = |k: usize| k != i && !self.set_aside.contains(&k);
        let others = table.of(counts)?;
        let mut of_others = vec![0.0; others.lights().len()];
        others.weights_into(table.lights()[i], &mut of_others);
        let mut of_others = of_others.into_iter();
        let weight =
            |k: usize| if counts(k) { of_others.next().expect("a weight for each that counts") } else { 0.0 };
        Some((0..self.pairs.len()).map(weight).collect())
    }

    fn check(&self, field: &ReflectanceField) -> Result<()> {
        if self.pairs.is_empty() {
            return Err(Error::usage("a comparison needs at least one photograph, found none"));
        }
        if field.layout().is_named() {
            return Err(Error::usage(
                "a texture of named channels has no colour to compare with photographs",
            ));
        }
        match self.mask {
            Some(mask) if mask.len() != field.size().texels() || !mask.contains(&true) => {
                Err(Error::invalid(format!(
                    "the mask of {} texels does not leave a part of the texture of {}",
                    mask.len(),
                    field.size()
                )))
            }
            _ => Ok(()),
        }
    }
}

fn blacken(codes: &mut [u8], mask: &[bool]) {
    codes.chunks_exact_mut(3).zip(mask).filter(|(_, inside)| !**inside).for_each(|(texel, _)| texel.fill(0));
}

/// The mean squared difference of the codes of so many texels, with a peak of 1.
fn mean_square(a: &[u8], b: &[u8], texels: usize) -> f64 {
    let squares: u64 = a.iter().zip(b).map(|(a, b)| u64::from(a.abs_diff(*b)).pow(2)).sum();
    squares as f64 / (255.0 * 255.0 * 3.0 * texels as f64)
}

/// Three 8-bit sRGB codes a texel.
fn codes(photograph: &Raster) -> Vec<u8> {
    let channels = photograph.channels();
    if let (Samples::U8(codes), 3) = (photograph.samples(), channels) {
        return codes.clone();
    }
    let picture = photograph.to_picture(Space::Srgb);
    let plane = |c: usize| picture.planes.plane(c.min(channels - 1));
    let code = |value: f32| (255.0 * value.clamp(0.0, 1.0)).round() as u8;
    (0..photograph.size().texels()).flat_map(|t| (0..3).map(move |c| code(plane(c)[t]))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::direction::Direction;
    use crate::planes::Planes;

    fn grey(size: Size, code: u8) -> Raster {
        Raster::new(size, 1, Samples::U8(vec![code; size.texels()])).unwrap()
    }

    fn compare(
        field: &ReflectanceField,
        pairs: &[(String, Directions)],
        load: &LoadRaster,
        mask: Option<&[bool]>,
    ) -> Result<TestReport> {
        test(
            field,
            &ComparedPhotographs { pairs, load, lamps: None, mask, are_fitted: false, set_aside: Vec::new() },
            &Job::default(),
        )
    }

    #[test]
    fn the_figure_is_the_mean_over_pictures_of_encoded_codes() {
        let size = Size::new(5, 3);
        let value = Space::Srgb.to_linear(100.0 / 255.0);
        let planes = Planes::from_vec(size, 1, vec![value; 15]).unwrap();
        let field = ReflectanceField::from_picture(Picture { planes, space: Space::Linear });
        let pairs = [("a".to_owned(), Direction::ZENITH.into()), ("b".to_owned(), Direction::ZENITH.into())];
        let load = |i: usize| Ok(grey(size, [110, 80][i]));
        let report = compare(&field, &pairs, &load, None).unwrap();
        let db = |codes: f64| 20.0 * (255.0 / codes).log10();
        assert!((report.lights[0].psnr_db - db(10.0)).abs() < 1e-9);
        assert!((report.psnr_db - 0.5 * (db(10.0) + db(20.0))).abs() < 1e-9);
        assert_eq!(report.worst, 1);
    }

    /// A fault: one picture without an error made the mean infinite, and texels outside a mask counted as exact.
    #[test]
    fn exact_pictures_are_counted_and_only_texels_of_the_mask_are_compared() {
        let size = Size::new(5, 3);
        let value = Space::Srgb.to_linear(100.0 / 255.0);
        let planes = Planes::from_vec(size, 1, vec![value; 15]).unwrap();
        let field = ReflectanceField::from_picture(Picture { planes, space: Space::Linear });
        let pairs = ["a", "b"].map(|name| (name.to_owned(), Direction::ZENITH.into()));
        let load = |i: usize| Ok(grey(size, [110, 100][i]));
        let mask: Vec<bool> = (0..15).map(|i| i < 4).collect();
        let report = compare(&field, &pairs, &load, Some(&mask)).unwrap();
        assert!((report.psnr_db - 20.0 * 25.5f64.log10()).abs() < 1e-9, "{report:?}");
        assert_eq!((report.exact, report.texels), (1, 4));
        assert!(report.lights[1].psnr_db.is_infinite());
        assert!(compare(&field, &pairs, &load, Some(&[false; 15])).is_err());
    }

    #[test]
    fn photographs_of_another_size_are_refused_by_name() {
        let planes = Planes::zeros(Size::new(2, 2), 1);
        let field = ReflectanceField::from_picture(Picture { planes, space: Space::Linear });
        let pairs = [("left.png".to_owned(), Direction::ZENITH.into())];
        let load = |_| Ok(grey(Size::new(3, 2), 0));
        let error = compare(&field, &pairs, &load, None).unwrap_err().to_string();
        assert!(error.contains("left.png") && error.contains("same size"), "{error}");
        assert!(compare(&field, &[], &load, None).is_err());
    }
}
