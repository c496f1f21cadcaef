//! Fits with a ridge, and photographs that are interpolated.

use super::*;

#[test]
fn a_ridge_is_the_penalised_least_squares() {
    let (lights, photographs) = capture(1, 30);
    let weight = 0.01;
    let options = FitOptions {
        basis: Basis::from_name("hsh16").unwrap(),
        ridge: Ridge::Weight(weight),
        ..FitOptions::default()
    };
    let fitted = run(&lights, &photographs, &options);
    assert_eq!(fitted.report.ridge, Some(weight));
    let rows: Vec<Vec<f64>> = lights.iter().map(|(_, light)| options.basis.weights(*light)).collect();
    let roughness = options.basis.roughness().unwrap();
    let values: Vec<f64> =
        photographs.iter().map(|p| f64::from(p.to_picture(Space::Srgb).planes.plane(0)[40])).collect();
    let coefficients: Vec<f64> =
        fitted.field.coefficients().iter().map(|plane| f64::from(plane[40])).collect();
    // The gradient of the penalised error vanishes.
    for k in 0..16 {
        let residual = |(row, value): (&Vec<f64>, &f64)| {
            row[k] * (row.iter().zip(&coefficients).map(|(w, c)| w * c).sum::<f64>() - value)
        };
        let data: f64 = rows.iter().zip(&values).map(residual).sum();
        let penalty: f64 = (0..16).map(|j| 30.0 * weight * roughness[(k, j)] * coefficients[j]).sum();
        assert!((data + penalty).abs() < 1e-3, "function {k}: {data} and {penalty}");
    }
}

#[test]
fn the_ridge_chosen_predicts_photographs_better_than_least_squares() {
    let (lights, photographs) = capture(3, 32);
    let left_out = |ridge: Ridge| {
        let options = FitOptions {
            basis: Basis::from_name("hsh25").unwrap(),
            layout: PlaneLayout::RGB,
            leave_one_out: true,
            ridge,
            ..FitOptions::default()
        };
        let report = run(&lights, &photographs, &options).report;
        (report.leave_one_out.unwrap().psnr_db, report.ridge, report.warnings.len())
    };
    let (plain, chosen) = (left_out(Ridge::None), left_out(Ridge::LeaveOneOut));
    assert!(chosen.0 > plain.0 + 1.0 && chosen.1.is_some(), "{plain:?} {chosen:?}");
    assert!(plain.2 > 0, "many functions for the photographs are said");
}

#[test]
fn a_ridge_and_robust_fits_of_interpolated_photographs_are_refused() {
    let (lights, photographs) = capture(1, 12);
    let directions: Vec<Direction> = lights.iter().map(|(_, light)| *light).collect();
    let table =
        crate::field::Interpolated::new(&directions, crate::field::Interpolation::RadialBasis).unwrap();
    let message = |options: FitOptions| {
        fit(&lights, &|i| Ok(photographs[i].clone()), &options, &Job::default()).unwrap_err().to_string()
    };
    let interpolated = FitOptions { basis: Basis::Interpolated(table), ..FitOptions::default() };
    let ridge = message(FitOptions { ridge: Ridge::LeaveOneOut, ..interpolated.clone() });
    assert!(ridge.contains("the basis rbf keeps the photographs"), "{ridge}");
    let weight = message(FitOptions { ridge: Ridge::Weight(-1.0), ..FitOptions::default() });
    assert!(weight.contains("above 0 and up to 1000000, found -1"), "{weight}");
    let heavy = message(FitOptions { ridge: Ridge::Weight(1e300), ..FitOptions::default() });
    assert!(heavy.contains("up to 1000000"), "{heavy}");
    let robust = FitOptions { robust: Robust::Trimmed, leave_one_out: true, ..FitOptions::default() };
    assert!(message(robust).contains("without a robust fit"));
}

/// The photographs are the coefficients, and the error of each left out is that of the others interpolated.
#[test]
fn interpolated_photographs_are_kept_and_left_out() {
    let (lights, photographs) = capture(1, 20);
    let directions: Vec<Direction> = lights.iter().map(|(_, light)| *light).collect();
    for rule in crate::field::Interpolation::ALL {
        let table = crate::field::Interpolated::new(&directions, rule).unwrap();
        let options = FitOptions {
            basis: Basis::Interpolated(table.clone()),
            leave_one_out: true,
            ..FitOptions::default()
        };
        let fitted = run(&lights, &photographs, &options);
        let pictures: Vec<_> = photographs.iter().map(|p| p.to_picture(Space::Srgb)).collect();
        for (k, picture) in pictures.iter().enumerate() {
            assert_eq!(fitted.field.coefficients().plane(k), picture.planes.plane(0));
        }
        let others = table.without(3).unwrap();
        let mut weights = vec![0.0; 19];
        others.weights_into(directions[3], &mut weights);
        let rest: Vec<_> = (0..20).filter(|k| *k != 3).collect();
        let error = |t: usize| {
            let value = |k: usize| f64::from(pictures[k].planes.plane(0)[t]);
            let predicted: f64 = rest.iter().zip(&weights).map(|(k, w)| w * value(*k)).sum();
            (predicted.clamp(0.0, 1.0) - value(3)).powi(2)
        };
        let texels = pictures[0].size().texels();
        let rmse = ((0..texels).map(error).sum::<f64>() / texels as f64).sqrt();
        let found = fitted.report.lights[3].leave_one_out.unwrap().rmse;
        assert!((found - rmse).abs() < 1e-5, "{rule:?}: {found} and {rmse}");
    }
}
