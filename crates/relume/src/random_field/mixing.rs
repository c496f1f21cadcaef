//! Planes as linear combinations of uncorrelated components, by Gram-Schmidt.
//!
//! Colour channels are nearly redundant. The field is modelled in components c with z = L c, where z are the
//! scores of the planes: the first component is the first plane, each further one is the part of a plane not
//! determined by those before it, scaled to variance one. There is no rotation, so components of similar
//! textures, such as one material under several lights, correspond. A plane determined by the earlier ones
//! has no component of its own.

use crate::numeric::Matrix;
use crate::planes::Planes;

/// z = L c.
#[derive(Debug, Clone, PartialEq)]
pub struct Mixing {
    /// For each plane, whether it has its own component.
    pub own: Vec<bool>,
    /// The rows of L up to and including the component of the plane itself, one after another.
    pub weights: Vec<f32>,
}

impl Mixing {
    /// The components of planes of mean zero. A plane with less than `least` of its variance undetermined by
    /// the earlier ones gets no component.
    pub fn of(scores: &Planes, least: f64) -> Self {
        let (d, n) = (scores.count(), scores.size().texels() as f64);
        let product = |a: usize, b: usize| {
            let terms =
                scores.plane(a).iter().zip(scores.plane(b)).map(|(x, y)| f64::from(*x) * f64::from(*y));
            terms.sum::<f64>() / n
        };
        let covariance = Matrix::from_fn(d, d, |a, b| if a >= b { product(a, b) } else { 0.0 });
        let mut mixing = Self { own: Vec::new(), weights: Vec::new() };
        let (mut rows, mut pivots): (Vec<Vec<f64>>, Vec<usize>) = (Vec::new(), Vec::new());
        for plane in 0..d {
            let mut row: Vec<f64> = Vec::new();
            for (k, &pivot) in pivots.iter().enumerate() {
                let known: f64 = (0..k).map(|i| row[i] * rows[pivot][i]).sum();
                row.push((covariance[(plane, pivot)] - known) / rows[pivot][k]);
            }
            let rest = covariance[(plane, plane)] - row.iter().map(|w| w * w).sum::<f64>();
            let own = rest > least * covariance[(plane, plane)].max(f64::MIN_POSITIVE);
            if own {
                row.push(rest.sqrt());
                pivots.push(plane);
            }
            mixing.own.push(own);
            mixing.weights.extend(row.iter().map(|&w| w as f32));
            rows.push(row);
        }
        mixing
    }

    /// The number of components m.
    pub fn components(&self) -> usize {
        self.own.iter().filter(|own| **own).count()
    }

    /// For each plane its weights, and whether it has its own component.
    fn rows(&self) -> impl Iterator<Item = (&[f32], bool)> {
        let (mut start, mut components) = (0, 0);
        self.own.iter().map(move |&own| {
            components += usize::from(own);
            start += components;
            (&self.weights[start - components..start], own)
        })
    }

    /// The magnitude of each component over all planes of given lengths: the root of the sum of its squared
    /// weights, each times the length of the plane.
    pub fn norms(&self, lengths: &[f64]) -> Vec<f64> {
        let mut squares = vec![0.0; self.components()];
        for ((weights, _), length) in self.rows().zip(lengths) {
            squares.iter_mut().zip(weights).for_each(|(sum, &w)| *sum += (length * f64::from(w)).powi(2));
        }
        squares.into_iter().map(f64::sqrt).collect()
    }

    /// The components of given planes.
    pub fn components_of(&self, scores: &Planes) -> Planes {
        let mut components = Planes::zeros(scores.size(), self.components());
        let texels = scores.size().texels();
        let own = self.rows().enumerate().filter(|(_, (_, own))| *own);
        for (k, (plane, (weights, _))) in own.enumerate() {
            let (known, own) = components.as_mut_slice().split_at_mut(k * texels);
            let own = &mut own[..texels];
            own.copy_from_slice(scores.plane(plane));
            for (weight, known) in weights.iter().zip(known.chunks_exact(texels)) {
                own.iter_mut().zip(known).for_each(|(o, v)| *o -= weight * v);
            }
            own.iter_mut().for_each(|o| *o /= weights[k]);
        }
        components
    }

    /// The planes of given components, one texel at a time.
    pub fn planes_of(&self, components: &Planes) -> Planes {
        let mut planes = Planes::zeros(components.size(), self.own.len());
        for (plane, (weights, _)) in self.rows().enumerate() {
            let out = planes.plane_mut(plane);
            for (weight, component) in weights.iter().zip(components.iter()) {
                out.iter_mut().zip(component).for_each(|(o, v)| *o += weight * v);
            }
        }
        planes
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::random::{Purpose, Stream};
    use crate::size::Size;

    #[test]
    fn components_are_uncorrelated_and_lead_back_to_the_planes() {
        let (size, mut stream) = (Size::new(40, 30), Stream::new(8, Purpose::Sample, [0]));
        let mut planes = Planes::zeros(size, 5);
        for t in 0..size.texels() {
            let [a, b, c] = [(); 3].map(|()| stream.unit() as f32 * 3.0 - 1.5);
            // The third plane is a combination of the others, the fourth is zero.
            let texel = [a, 0.9 * a + 0.1 * b, 2.0 * a - b, 0.0, c - b];
            (0..5).for_each(|k| planes.plane_mut(k)[t] = texel[k]);
        }
        for plane in planes.iter_mut() {
            let mean = plane.iter().sum::<f32>() / size.texels() as f32;
            plane.iter_mut().for_each(|v| *v -= mean);
        }
        let mixing = Mixing::of(&planes, 1e-5);
        assert_eq!(mixing.own, [true, true, false, false, true]);
        let components = mixing.components_of(&planes);
        for a in 0..3 {
            for b in 0..3 {
                let dot: f32 = components.plane(a).iter().zip(components.plane(b)).map(|(x, y)| x * y).sum();
                let truth = f32::from(u8::from(a == b));
                assert!((dot / size.texels() as f32 - truth).abs() < 0.02, "{a} {b}");
            }
        }
        let back = mixing.planes_of(&components);
        let deviation = planes.as_slice().iter().map(|v| v * v).sum::<f32>().sqrt();
        let error =
            planes.as_slice().iter().zip(back.as_slice()).map(|(a, b)| (a - b).powi(2)).sum::<f32>().sqrt();
        assert!(error < 2e-3 * deviation, "{error} of {deviation}");
    }
}
