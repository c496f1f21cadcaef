//! Lamps near the surface, whose light comes from another direction at each texel.

use super::*;
use crate::lamps::LampPositions;

const SIZE: Size = Size::new(41, 29);

/// Lamps at a third of the surface's width above it, and wider around it.
fn lamps() -> LampPositions {
    let place = |i: usize| {
        let (polar, around) = (0.2 + 0.05 * i as f64, 2.4 * i as f64);
        [120.0 * polar.sin() * around.cos(), 120.0 * polar.sin() * around.sin(), 40.0 + 60.0 * polar.cos()]
    };
    LampPositions::new((0..20).map(place).collect(), (SIZE.width, SIZE.height), 100.0).unwrap()
}

/// The coefficients of the texture that was photographed.
fn truth(texel: usize, k: usize) -> f32 {
    0.1 + 0.02 * ((texel * (k + 3)) % 17) as f32
}

fn near_photographs(lamps: &LampPositions) -> (Vec<(String, Direction)>, Vec<Raster>) {
    let lights = (0..lamps.count()).map(|i| (format!("p{i}.png"), lamps.direction(i))).collect();
    let value = |i: usize, texel: usize| {
        let [x, y, z] = lamps.at(i, texel % SIZE.width, texel / SIZE.width).0;
        let weights = Basis::Ptm.weights(Direction::new(x, y, z).unwrap());
        weights.iter().enumerate().map(|(k, w)| *w as f32 * truth(texel, k)).sum::<f32>()
    };
    let photograph = |i| Samples::F32((0..SIZE.texels()).map(|texel| value(i, texel)).collect());
    let photographs = (0..lamps.count()).map(|i| Raster::new(SIZE, 1, photograph(i)).unwrap()).collect();
    (lights, photographs)
}

#[test]
fn functions_under_near_lamps_are_those_of_the_surface() {
    let lamps = lamps();
    let (lights, photographs) = near_photographs(&lamps);
    let fit = |near: bool, robust| {
        let lamps = near.then(|| lamps.clone());
        run(
            &lights,
            &photographs,
            &FitOptions { lamps, robust, space: Space::Linear, ..FitOptions::default() },
        )
    };
    let error = |fit: &Fit| {
        let planes = fit.field.coefficients();
        let of_plane = |k: usize| (0..SIZE.texels()).map(move |t| (planes.plane(k)[t] - truth(t, k)).abs());
        (0..6).flat_map(of_plane).fold(0.0f32, f32::max)
    };
    let far = fit(false, Robust::None);
    assert!(error(&far) > 0.05, "the directions in the middle would do: {}", error(&far));
    for robust in [Robust::None, Robust::Reweighted] {
        let near = fit(true, robust);
        assert!(error(&near) < 2e-4, "{robust:?}: {}", error(&near));
        assert!(
            near.report.error.psnr_db > 90.0 && far.report.error.psnr_db < 50.0,
            "{:?}",
            near.report.error
        );
    }
}

#[test]
fn near_lamps_of_interpolated_photographs_are_refused() {
    let lamps = lamps();
    let (lights, photographs) = near_photographs(&lamps);
    let directions: Vec<Direction> = lights.iter().map(|(_, light)| *light).collect();
    let table =
        crate::field::Interpolated::new(&directions, crate::field::Interpolation::RadialBasis).unwrap();
    let options =
        FitOptions { basis: Basis::Interpolated(table), lamps: Some(lamps.clone()), ..FitOptions::default() };
    let text = failure(&lights, &photographs, &options);
    assert!(text.contains("one light each"), "{text}");
    let left_out = FitOptions { leave_one_out: true, lamps: Some(lamps), ..FitOptions::default() };
    assert!(failure(&lights, &photographs, &left_out).contains("without near lamps"));
}
