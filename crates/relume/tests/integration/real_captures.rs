//! Fits of measured and rendered captures, where they are available: the figures are printed, and predictions
//! of photographs left out of the fit must be as accurate as is known for polynomial texture maps.

use std::path::Path;

use relume::capture::Capture;
use relume::field::PlaneLayout;
use relume::fit::{Fit, FitOptions, fit};
use relume::format::read_raster;
use relume::metric::psnr;
use relume::{Job, Planes, Raster, ReflectanceField, Result, Size, Space};

use crate::support::data;

fn read(path: &Path) -> Result<Raster> {
    read_raster(path, &Job::default())
}

fn fitted(capture: &Capture, options: &FitOptions) -> Fit {
    let load = |i: usize| read(&capture.photographs[i].path);
    fit(&capture.lights(), &load, options, &Job::default()).unwrap()
}

/// The published figures for this capture have two decimals, so they are matched to half of the last one;
/// decoders of JPEG differ by 0.001 dB (20.1763 dB by another fit of the same pictures decoded by libjpeg).
const KNOWN_TO_DB: f64 = 0.005;

/// The mean over photographs of the PSNR of the relit values.
fn mean_psnr(field: &ReflectanceField, capture: &Capture) -> f64 {
    let one = |photograph: &relume::capture::Photograph| {
        let truth = read(&photograph.path).unwrap().to_picture(Space::Srgb).planes;
        let mut relit = Planes::zeros(truth.size(), 3);
        for texel in 0..truth.size().texels() {
            let (x, y) = (texel % truth.size().width, texel / truth.size().width);
            let color = field.value(x, y, photograph.light);
            (0..3).for_each(|c| relit.plane_mut(c)[texel] = color[c].clamp(0.0, 1.0));
        }
        psnr(&relit, &truth).unwrap()
    };
    capture.photographs.iter().map(one).sum::<f64>() / capture.photographs.len() as f64
}

#[test]
fn lights_never_seen_are_predicted_as_well_as_polynomials_can() {
    let Some(folder) = data("captures/synthrti") else { return };
    let dome = Capture::open(folder.join("Dome")).unwrap();
    let test = Capture::open(folder.join("Test")).unwrap();
    assert_eq!((dome.photographs.len(), test.photographs.len()), (49, 20));
    for (color, known) in [(PlaneLayout::RGB, 20.18), (PlaneLayout::LRGB, 19.96)] {
        let options = FitOptions { layout: color.clone(), leave_one_out: true, ..FitOptions::default() };
        let Fit { field, report } = fitted(&dome, &options);
        let held_out = mean_psnr(&field, &test);
        println!(
            "synthrti {}: held-out {held_out:.5} dB, fit {:.2} dB, leave-one-out {:.2} dB, condition {:.1}",
            color.name(),
            report.error.psnr_db,
            report.leave_one_out.unwrap().psnr_db,
            report.condition_number
        );
        assert!(held_out > known - KNOWN_TO_DB, "{} {held_out:.4} dB, known {known}", color.name());
    }
}

#[test]
fn measured_fabrics_are_fitted() {
    for name in ["wool", "corduroy"] {
        let Some(folder) = data(&format!("captures/{name}")) else { continue };
        let capture = Capture::open(&folder).unwrap();
        assert_eq!(capture.photographs.len(), 81);
        for (color, space) in [
            (PlaneLayout::LRGB, Space::Srgb),
            (PlaneLayout::RGB, Space::Srgb),
            (PlaneLayout::LRGB, Space::Linear),
        ] {
            let options =
                FitOptions { layout: color.clone(), space, leave_one_out: true, ..FitOptions::default() };
            let Fit { field, report } = fitted(&capture, &options);
            let worst = report.worst_light();
            println!(
                "{name} {} {space}: {:.2} dB, leave-one-out {:.2} dB, worst {} {:.2} dB, condition {:.1}",
                color.name(),
                report.error.psnr_db,
                report.leave_one_out.unwrap().psnr_db,
                worst.name,
                worst.error.psnr_db,
                report.condition_number
            );
            assert_eq!((field.size(), report.texels_measured), (Size::new(256, 256), 65_536));
            assert!(report.warnings.is_empty(), "{:?}", report.warnings);
            assert!(report.error.psnr_db > report.leave_one_out.unwrap().psnr_db);
        }
    }
}
