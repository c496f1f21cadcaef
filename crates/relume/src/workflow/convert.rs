//! A texture expressed otherwise: in other functions, in the other space, with other colours; and what that loses.
//!
//! Within one space, functions of light are linear in their coefficients: a matrix, found once by least squares over
//! the hemisphere ([`refit`](crate::field::refit)), takes all coefficients at once, exactly where the new functions span
//! the old ones. Between spaces the encoding bends values, so that each texel is fitted to its own encoded values under
//! many lights. What is lost is measured on relit values under other lights.

use std::borrow::Cow;

use serde::Serialize;

use crate::direction::{Direction, Directions};
use crate::error::{Error, Result};
use crate::field::lrgb::nearest_product;
use crate::field::refit::refit;
use crate::field::{Basis, Domain, PlaneLayout, ReflectanceField};
use crate::job::Job;
use crate::numeric::Matrix;
use crate::numeric::matrix::Qr;
use crate::parallel;
use crate::planes::Planes;
use crate::space::Space;

/// Lights under which values are converted to the other space.
pub(super) const SAMPLED_LIGHTS: usize = 96;

/// Lights under which the loss is measured: none of those of the fit.
pub(super) const CHECKED_LIGHTS: usize = 61;

/// About so many texels are measured.
const CHECKED_TEXELS: usize = 1 << 14;

/// What a texture is to be; `None` stays as it is.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ConvertOptions {
    /// The functions.
    pub basis: Option<Basis>,
    /// Linear, or sRGB-encoded values.
    pub space: Option<Space>,
    /// The arrangement: RGB, luminance times colour, or luminance.
    pub layout: Option<PlaneLayout>,
}

/// Differences of relit values, with white at 1, over lights spread evenly and texels spread evenly.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct RefitLoss {
    /// The root mean square.
    pub rms: f64,
    /// The largest in size of those compared.
    pub largest: f64,
    /// The number of lights.
    pub lights: usize,
}

impl RefitLoss {
    /// From the sum of squares, the largest and the number of the differences under each light.
    pub(super) fn of(lights: Vec<(f64, f64, usize)>) -> Self {
        let count = lights.len();
        let (squares, largest, values) =
            lights.into_iter().fold((0.0, 0.0f64, 0), |a, b| (a.0 + b.0, a.1.max(b.1), a.2 + b.2));
        Self { rms: (squares / values.max(1) as f64).sqrt(), largest, lights: count }
    }
}

/// The texture as asked for; borrowed where that changes nothing.
///
/// Functions of light and view are taken as seen from straight above.
///
/// # Errors
/// A basis with data of its own, colours that the texture does not have, the limits, and a cancelled job.
pub fn convert<'a>(
    field: &'a ReflectanceField,
    options: &ConvertOptions,
    job: &Job,
) -> Result<Cow<'a, ReflectanceField>> {
    let basis = options.basis.as_ref().unwrap_or(field.basis());
    let space = options.space.unwrap_or(field.space());
    if field.basis().depends_on_view() && basis != field.basis() {
        job.remark("the functions depend on the view: they are taken as seen from straight above");
    }
    let same_basis = basis == field.basis();
    let made = match space == field.space() {
        true if same_basis => Cow::Borrowed(field),
        true => Cow::Owned(in_basis(field, basis, job)?),
        false => Cow::Owned(in_space(field, basis, space, job)?),
    };
    arranged(made, options.layout.as_ref(), job)
}

/// The loss of relit values of `made` for `field`, in the space of `made`.
///
/// # Errors
/// Channels that do not match, and a cancelled job.
pub fn refit_loss(field: &ReflectanceField, made: &ReflectanceField, job: &Job) -> Result<RefitLoss> {
    let channels = field.layout().channels().max(made.layout().channels());
    let step = (field.size().texels() / CHECKED_TEXELS).max(1);
    // A step that shares no factor with the width does not stay in a column.
    let step = (step..).find(|step| gcd(*step, field.size().width) == 1).unwrap_or(1);
    let light = Direction::fibonacci(CHECKED_LIGHTS);
    let of_light = |i: usize| {
        job.proceed()?;
        let (from, to) = (field.basis().weights(light(i)), made.basis().weights(light(i)));
        let mut sums = (0.0, 0.0f64, 0usize);
        for texel in (0..field.size().texels()).step_by(step) {
            let (x, y) = (texel % field.size().width, texel / field.size().width);
            for c in 0..channels {
                let of = |f: &ReflectanceField, weights: &[f64]| {
                    f.channel_value(c.min(f.layout().channels() - 1), x, y, weights)
                };
                let truth = in_space_of(made, field.space(), of(field, &from));
                let error = f64::from(of(made, &to)) - f64::from(truth);
                sums = (sums.0 + error * error, sums.1.max(error.abs()), sums.2 + 1);
            }
        }
        Ok(sums)
    };
    let all: Vec<(f64, f64, usize)> = parallel::try_map(0..CHECKED_LIGHTS, of_light)?;
    Ok(RefitLoss::of(all))
}

/// A value in the space of a field: as it is where that is its own.
fn in_space_of(made: &ReflectanceField, space: Space, value: f32) -> f32 {
    if made.space() == space { value } else { made.space().from_linear(space.to_linear(value)) }
}

fn gcd(a: usize, b: usize) -> usize {
    if b == 0 { a } else { gcd(b, a % b) }
}

/// The same space and arrangement, other functions: one matrix for each channel.
fn in_basis(field: &ReflectanceField, basis: &Basis, job: &Job) -> Result<ReflectanceField> {
    let old = field.basis();
    let n = old.len();
    let layout = match field.layout().is_shared() {
        true => PlaneLayout::of_channels(field.layout().channel_names())?,
        false => field.layout().clone(),
    };
    let of_channel = |channel: usize| {
        refit(basis, n, |light, out| {
            let weights = old.weights(light);
            out.copy_from_slice(field.layout().weights(channel, n, &weights));
        })
    };
    let functions = layout.functions();
    let matrices: Vec<Matrix> = match old.channels() {
        1 => vec![of_channel(0)?],
        channels => (0..channels).map(of_channel).collect::<Result<_>>()?,
    };
    let m = basis.len();
    let mut planes = Planes::zeros_within(job, "the converted texture", field.size(), layout.planes(m))?;
    let texels = field.size().texels();
    parallel::try_for_each(planes.as_mut_slice().chunks_mut(texels).enumerate(), |(k, out)| {
        job.proceed()?;
        if k >= functions * m {
            out.copy_from_slice(field.coefficients().plane(functions * n + k - functions * m));
            return Ok(());
        }
        let (function, row) = (k / m, k % m);
        let matrix = &matrices[function.min(matrices.len() - 1)];
        let first = if field.layout().is_shared() { 0 } else { function * n };
        for (j, &factor) in matrix.row(row).iter().enumerate().filter(|(_, factor)| **factor != 0.0) {
            let from = field.coefficients().plane(first + j);
            out.iter_mut().zip(from).for_each(|(out, &v)| *out += factor as f32 * v);
        }
        Ok(())
    })?;
    Ok(ReflectanceField::new(basis.clone(), layout, field.space(), planes)?
        .with_lights(field.lights().to_vec()))
}

/// The other space: each channel of each texel is fitted to its values there.
fn in_space(field: &ReflectanceField, basis: &Basis, space: Space, job: &Job) -> Result<ReflectanceField> {
    if basis.channels() != 1 || basis.depends_on_view() {
        return Err(Error::usage(format!(
            "values of the basis {} are not converted between linear and encoded: name a basis of light, such as hsh9",
            basis.name()
        )));
    }
    let light = Direction::fibonacci(SAMPLED_LIGHTS);
    let lights: Vec<Vec<f64>> = (0..SAMPLED_LIGHTS).map(|i| field.basis().weights(light(i))).collect();
    let mut design = Matrix::zeros(SAMPLED_LIGHTS, basis.len());
    for i in 0..SAMPLED_LIGHTS {
        basis.weights_into(Directions::lit_from(light(i)), design.row_mut(i));
    }
    let inverse = Qr::new(&design).pseudo_inverse();
    let layout = PlaneLayout::of_channels(field.layout().channel_names())?;
    let (m, texels, width) = (basis.len(), field.size().texels(), field.size().width);
    let mut planes = Planes::zeros_within(job, "the converted texture", field.size(), layout.planes(m))?;
    let mut bands = planes.bands_mut(width);
    parallel::try_for_each(bands.iter_mut().enumerate(), |(y, band)| {
        job.proceed()?;
        let mut values = vec![0.0; SAMPLED_LIGHTS];
        for (x, channel) in (0..width.min(texels)).flat_map(|x| (0..layout.channels()).map(move |c| (x, c))) {
            for (value, weights) in values.iter_mut().zip(&lights) {
                let linear = field.space().to_linear(field.channel_value(channel, x, y, weights));
                *value = f64::from(space.from_linear(linear));
            }
            for k in 0..m {
                let sum: f64 = inverse.row(k).iter().zip(&values).map(|(a, b)| a * b).sum();
                band[channel * m + k][x] = sum as f32;
            }
        }
        Ok(())
    })?;
    drop(bands);
    Ok(ReflectanceField::new(basis.clone(), layout, space, planes)?.with_lights(field.lights().to_vec()))
}

/// The colours as asked for.
pub(super) fn arranged<'a>(
    field: Cow<'a, ReflectanceField>,
    layout: Option<&PlaneLayout>,
    job: &Job,
) -> Result<Cow<'a, ReflectanceField>> {
    let Some(layout) = layout.filter(|layout| *layout != field.layout()) else { return Ok(field) };
    if field.layout().is_named() || field.layout().is_shared() {
        return Err(Error::usage(format!(
            "the channels {} are not rearranged as {}",
            field.layout().channel_names().join(", "),
            layout.name()
        )));
    }
    if *layout == PlaneLayout::RGB {
        let made = match field.layout().channels() {
            1 => repeated(&field, job)?,
            _ => field.of_channels(&["R", "G", "B"], job)?,
        };
        return Ok(Cow::Owned(made));
    }
    if *layout == PlaneLayout::LRGB && *field.layout() == PlaneLayout::RGB {
        return products(&field, job).map(Cow::Owned);
    }
    Err(Error::usage(format!(
        "colours of the arrangement {} are not made {}: name rgb",
        field.layout().name(),
        layout.name()
    )))
}

/// A luminance as three equal channels.
fn repeated(field: &ReflectanceField, job: &Job) -> Result<ReflectanceField> {
    let n = field.basis().len();
    let mut planes = Planes::zeros_within(job, "the converted texture", field.size(), 3 * n)?;
    planes
        .as_mut_slice()
        .chunks_exact_mut(n * field.size().texels())
        .for_each(|channel| channel.copy_from_slice(field.coefficients().as_slice()));
    let made = ReflectanceField::new(field.basis().clone(), PlaneLayout::RGB, field.space(), planes)?;
    Ok(made.with_lights(field.lights().to_vec()))
}

/// The nearest products of a function and a colour, texel by texel.
fn products(field: &ReflectanceField, job: &Job) -> Result<ReflectanceField> {
    let n = field.basis().len();
    // In coordinates in which the distance of functions is that of numbers: y = L' x with the Gram matrix L L'.
    let gram = field.basis().gram(Domain::Hemisphere)?;
    let factor = Matrix::from_fn(n, n, |r, c| gram.at(r, c)).cholesky()?.transposed();
    let back = factor.transposed().lower_inverse().transposed();
    let mut planes = Planes::zeros_within(job, "the converted texture", field.size(), n + 3)?;
    let (width, from) = (field.size().width, field.coefficients());
    let mut bands = planes.bands_mut(width);
    parallel::try_for_each(bands.iter_mut().enumerate(), |(y, band)| {
        job.proceed()?;
        let (mut channels, mut luminance) = (vec![vec![0f32; n]; 3], vec![0f32; n]);
        (0..width).for_each(|x| {
            for (c, channel) in channels.iter_mut().enumerate() {
                let value = |k: usize| f64::from(from.at(c * n + k, x, y));
                for (r, out) in channel.iter_mut().enumerate() {
                    *out = (r..n).map(|k| factor[(r, k)] * value(k)).sum::<f64>() as f32;
                }
            }
            let color = nearest_product([&channels[0], &channels[1], &channels[2]], &mut luminance);
            for r in 0..n {
                let sum: f64 = (r..n).map(|k| back[(r, k)] * f64::from(luminance[k])).sum();
                band[r][x] = sum as f32;
            }
            (0..3).for_each(|c| band[n + c][x] = color[c]);
        });
        Ok(())
    })?;
    drop(bands);
    let made = ReflectanceField::new(field.basis().clone(), PlaneLayout::LRGB, field.space(), planes)?;
    Ok(made.with_lights(field.lights().to_vec()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::random::{Purpose, Stream};
    use crate::size::Size;

    fn field(layout: PlaneLayout, space: Space) -> ReflectanceField {
        let mut random = Stream::new(7, Purpose::Sample, [0]);
        let size = Size::new(9, 7);
        let count = layout.planes(6);
        let mut planes = Planes::zeros(size, count);
        for (k, plane) in planes.iter_mut().enumerate() {
            // A bright constant with gentle slopes, so that values stay in range.
            let is_color = count == 9 && k >= 6;
            let (mean, spread) = if k % 6 == 5 || is_color { (0.5, 0.2) } else { (0.0, 0.15) };
            plane.iter_mut().for_each(|v| *v = mean + spread * (random.unit() as f32 - 0.5));
        }
        ReflectanceField::new(Basis::Ptm, layout, space, planes).unwrap()
    }

    fn named(name: &str) -> Basis {
        Basis::from_name(name).unwrap()
    }

    #[test]
    fn what_the_new_functions_span_is_kept_and_the_loss_says_so() {
        let constant = {
            let planes =
                Planes::from_vec(Size::new(2, 2), 3, (0..12).map(|i| i as f32 / 12.0).collect()).unwrap();
            ReflectanceField::new(Basis::Constant, PlaneLayout::RGB, Space::Srgb, planes).unwrap()
        };
        for basis in ["ptm", "hsh9"] {
            let options = ConvertOptions { basis: Some(named(basis)), ..ConvertOptions::default() };
            let made = convert(&constant, &options, &Job::default()).unwrap();
            assert_eq!(made.basis().name(), basis);
            let loss = refit_loss(&constant, &made, &Job::default()).unwrap();
            assert!(loss.largest < 1e-5, "{basis}: {loss:?}");
        }
    }

    #[test]
    fn no_other_coefficients_are_nearer_over_the_hemisphere() {
        let field = field(PlaneLayout::LUMINANCE, Space::Srgb);
        let options = ConvertOptions { basis: Some(named("hsh9")), ..ConvertOptions::default() };
        let made = convert(&field, &options, &Job::default()).unwrap();
        let distance = |made: &ReflectanceField| {
            crate::numeric::quadrature::integrate_hemisphere(24, |w| {
                let error = field.channel_value(0, 3, 2, &field.basis().weights(w))
                    - made.channel_value(0, 3, 2, &made.basis().weights(w));
                f64::from(error).powi(2)
            })
        };
        let best = distance(&made);
        for k in 0..9 {
            for step in [-0.01, 0.01] {
                let mut planes = made.coefficients().clone();
                planes.plane_mut(k)[2 * 9 + 3] += step;
                let other = made.with_coefficients(planes).unwrap();
                assert!(distance(&other) > best, "coefficient {k}");
            }
        }
    }

    #[test]
    fn encoded_values_are_those_of_linear_ones_relit_and_encoded() {
        let linear = field(PlaneLayout::LRGB, Space::Linear);
        let options = ConvertOptions {
            basis: Some(named("hsh9")),
            space: Some(Space::Srgb),
            ..ConvertOptions::default()
        };
        let made = convert(&linear, &options, &Job::default()).unwrap();
        assert_eq!((made.space(), made.layout()), (Space::Srgb, &PlaneLayout::RGB));
        let loss = refit_loss(&linear, &made, &Job::default()).unwrap();
        assert!(loss.rms < 0.02 && loss.rms > 0.0, "{loss:?}");
    }

    #[test]
    fn products_come_back_as_products() {
        let product = field(PlaneLayout::LRGB, Space::Srgb);
        let rgb = ConvertOptions { layout: Some(PlaneLayout::RGB), ..ConvertOptions::default() };
        let lrgb = ConvertOptions { layout: Some(PlaneLayout::LRGB), ..ConvertOptions::default() };
        let apart = convert(&product, &rgb, &Job::default()).unwrap();
        let again = convert(&apart, &lrgb, &Job::default()).unwrap();
        assert_eq!(again.layout(), &PlaneLayout::LRGB);
        let loss = refit_loss(&product, &again, &Job::default()).unwrap();
        assert!(loss.largest < 1e-5, "{loss:?}");
    }
}
