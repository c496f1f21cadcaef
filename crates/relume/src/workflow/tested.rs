//! A fitted texture under lights whose photographs took no part in the fit.
//!
//! The texture is relit under each light and compared with the photograph as displays show both: sRGB-encoded 8-bit
//! values, whatever the space of the fit. The mean over pictures of the peak signal-to-noise ratio is the figure by
//! which the benchmarks SynthRTI and RealRTI compare (Dulecha, Fanni, Ponchio, Pellacini, Giachetti, "Neural reflectance
//! transformation imaging", The Visual Computer 36, 2020).

use serde::Serialize;

use crate::direction::Directions;
use crate::error::{Error, Result};
use crate::field::ReflectanceField;
use crate::job::Job;
use crate::numeric::decibel::psnr_db;
use crate::raster::{LoadRaster, Raster, Samples};
use crate::render::Relighter;
use crate::space::Space;

/// How a texture does under lights that were not fitted.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct TestReport {
    /// The mean over pictures, in dB; infinite (in JSON: null) for a picture without an error.
    pub psnr_db: f64,
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
    /// The peak signal-to-noise ratio of all values of the picture, in dB.
    pub psnr_db: f64,
}

/// Relights a texture under the lights of photographs, which `load` reads by number, and compares.
///
/// # Errors
/// No photograph, photographs of another size, channels without a colour, and errors of `load`.
pub fn test(
    field: &ReflectanceField,
    photographs: &[(String, Directions)],
    load: &LoadRaster,
    job: &Job,
) -> Result<TestReport> {
    if photographs.is_empty() {
        return Err(Error::usage("a test needs at least one photograph, found none"));
    }
    if field.layout().is_named() {
        return Err(Error::usage("a texture of named channels has no colour to compare with photographs"));
    }
    let bytes = 3 * field.size().texels();
    job.check_bytes("the relit picture and the photograph", 3 * bytes as u64)?;
    let relighter = Relighter::new(field, job)?;
    let mut relit = vec![0u8; bytes];
    let mut lights = Vec::with_capacity(photographs.len());
    for (i, (name, pair)) in photographs.iter().enumerate() {
        job.proceed()?;
        let photograph = load(i)?;
        if photograph.size() != field.size() {
            return Err(Error::invalid(format!(
                "the photograph {name} of the test is {} texels and the texture {}: both must have the same size",
                photograph.size(),
                field.size()
            )));
        }
        relighter.relight_srgb8(*pair, &mut relit);
        let mean = mean_square(&relit, &codes(&photograph));
        lights.push(TestedLight {
            name: name.clone(),
            direction: pair.light.to_array(),
            psnr_db: psnr_db(mean),
        });
    }
    let worst = (0..lights.len()).fold(0, |w, i| if lights[i].psnr_db < lights[w].psnr_db { i } else { w });
    let mean = lights.iter().map(|light| light.psnr_db).sum::<f64>() / lights.len() as f64;
    Ok(TestReport { psnr_db: mean, worst, lights })
}

/// The mean squared difference of codes, with a peak of 1.
fn mean_square(a: &[u8], b: &[u8]) -> f64 {
    let squares: u64 = a.iter().zip(b).map(|(a, b)| u64::from(a.abs_diff(*b)).pow(2)).sum();
    squares as f64 / (255.0 * 255.0 * a.len() as f64)
}

/// Three 8-bit sRGB codes a texel.
pub(super) fn codes(photograph: &Raster) -> Vec<u8> {
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
    use crate::picture::Picture;
    use crate::planes::Planes;
    use crate::size::Size;

    fn grey(size: Size, code: u8) -> Raster {
        Raster::new(size, 1, Samples::U8(vec![code; size.texels()])).unwrap()
    }

    #[test]
    fn the_figure_is_the_mean_over_pictures_of_encoded_codes() {
        let size = Size::new(5, 3);
        let value = Space::Srgb.to_linear(100.0 / 255.0);
        let planes = Planes::from_vec(size, 1, vec![value; 15]).unwrap();
        let field = ReflectanceField::from_picture(Picture { planes, space: Space::Linear });
        let pairs = [("a".to_owned(), Direction::ZENITH.into()), ("b".to_owned(), Direction::ZENITH.into())];
        let load = |i: usize| Ok(grey(size, [110, 80][i]));
        let report = test(&field, &pairs, &load, &Job::default()).unwrap();
        let db = |codes: f64| 20.0 * (255.0 / codes).log10();
        assert!((report.lights[0].psnr_db - db(10.0)).abs() < 1e-9);
        assert!((report.psnr_db - 0.5 * (db(10.0) + db(20.0))).abs() < 1e-9);
        assert_eq!(report.worst, 1);
    }

    #[test]
    fn photographs_of_another_size_are_refused_by_name() {
        let planes = Planes::zeros(Size::new(2, 2), 1);
        let field = ReflectanceField::from_picture(Picture { planes, space: Space::Linear });
        let pairs = [("left.png".to_owned(), Direction::ZENITH.into())];
        let load = |_| Ok(grey(Size::new(3, 2), 0));
        let error = test(&field, &pairs, &load, &Job::default()).unwrap_err().to_string();
        assert!(error.contains("left.png") && error.contains("same size"), "{error}");
        assert!(test(&field, &[], &load, &Job::default()).is_err());
    }
}
