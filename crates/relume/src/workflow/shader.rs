//! Data for shaders: the bytes of a polynomial texture map as pictures, and endless noise of functions.

use crate::error::{Error, Result};
use crate::field::{Domain, IndexSpace, Metric, PlaneLayout, ReflectanceField};
use crate::format::{Encoding, FieldFile, PtmEncoding};
use crate::job::Job;
use crate::picture::Picture;
use crate::planes::Planes;
use crate::size::Size;
use crate::space::Space;
use crate::synthesis::noise::gaussian::REACH;
use crate::synthesis::noise::{Noise, NoiseOptions};

/// The bytes of an LRGB texture map as three pictures, and the scale and bias that restore its
/// coefficients.
#[derive(Debug, Clone, PartialEq)]
pub struct PtmPictures {
    /// The first three coefficients, the last three, and the colour.
    pub pictures: [Picture; 3],
    /// Scale and bias of each coefficient.
    pub encoding: PtmEncoding,
}

impl PtmPictures {
    /// The pictures of a file.
    ///
    /// # Errors
    /// A file that is not a `.ptm`.
    pub fn new(file: &FieldFile) -> Result<Self> {
        let Encoding::Ptm(encoding) = file.encoding else {
            return Err(Error::invalid("the page needs a .ptm texture map"));
        };
        let bytes_of = |k: usize| -> Vec<f32> {
            let plane = file.field.coefficients().plane(k).iter();
            match (encoding.scale.get(k), encoding.bias.get(k)) {
                (Some(scale), Some(bias)) => {
                    plane.map(|v| (v * 255.0 / scale + bias).round() / 255.0).collect()
                }
                _ => plane.copied().collect(),
            }
        };
        let picture = |first: usize| -> Result<Picture> {
            let data = (first..first + 3).flat_map(bytes_of).collect();
            let planes = Planes::from_vec(file.field.size(), 3, data)?;
            Ok(Picture { planes, space: Space::Srgb })
        };
        let pictures = [picture(0)?, picture(3)?, picture(6)?];
        Ok(Self { pictures, encoding })
    }
}

/// Noise of functions, and the functions of its axes.
///
/// Under a given light the colour of a texel is linear in its index values, and those are the mean plus the
/// sum of the principal axes, each times the value of its plane. So a shader needs the normal values of the
/// planes, one byte each, the tables that restore the values, and the functions of the mean and of each axis,
/// which become one colour per light.
#[derive(Debug)]
pub struct NoiseFunctions {
    noise: Noise,
    functions: Vec<Vec<f32>>,
}

impl NoiseFunctions {
    /// Models a field of functions of red, green and blue.
    ///
    /// # Errors
    /// Other fields, exemplars unsuitable for noise, and limits exceeded.
    pub fn new(field: &ReflectanceField, job: &Job) -> Result<Self> {
        if *field.layout() != PlaneLayout::RGB {
            return Err(Error::invalid("the page needs functions of red, green and blue"));
        }
        let space = IndexSpace::new(field, Metric::Function, Domain::Hemisphere)?;
        let noise = Noise::new(
            &space.index_planes_within(field, job, "the index of the exemplar")?,
            &NoiseOptions::default(),
            job,
        )?;
        let functions = functions(&noise, &space, field)?;
        Ok(Self { noise, functions })
    }

    /// The noise.
    pub fn noise(&self) -> &Noise {
        &self.noise
    }

    /// The mean function as coefficients of red, green and blue, and then the contribution of each axis.
    pub fn functions(&self) -> &[Vec<f32>] {
        &self.functions
    }

    /// The number of planes.
    pub fn planes(&self) -> usize {
        self.noise.marginals().len()
    }

    /// The normal values from 0 to 1, three planes side by side as red, green and blue, the next three below.
    pub fn normals(&self) -> Picture {
        let (planes, size) = (self.noise.normal_planes(), self.noise.size());
        let layers = self.planes().div_ceil(3);
        let mut stacked = Planes::zeros(Size::new(size.width, layers * size.height), 3);
        for (k, plane) in planes.iter().enumerate() {
            let first = k / 3 * size.texels();
            let part = &mut stacked.plane_mut(k % 3)[first..][..size.texels()];
            part.iter_mut().zip(plane).for_each(|(out, normal)| *out = normal / REACH as f32 * 0.5 + 0.5);
        }
        Picture { planes: stacked, space: Space::Srgb }
    }
}

/// The function of the mean, and the contribution of each axis.
fn functions(noise: &Noise, space: &IndexSpace, like: &ReflectanceField) -> Result<Vec<Vec<f32>>> {
    let (means, axes) = noise.axes();
    let mut index = Planes::zeros(Size::new(axes.rows() + 1, 1), means.len());
    for (j, mean) in means.iter().enumerate() {
        let plane = index.plane_mut(j);
        plane.fill(*mean);
        (0..axes.rows()).for_each(|k| plane[k + 1] += axes[(k, j)] as f32);
    }
    let field = space.field(like, &index)?;
    let coefficients = field.coefficients();
    let of = |texel: usize| (0..coefficients.count()).map(move |c| coefficients.at(c, texel, 0));
    let added = (1..=axes.rows()).map(|k| of(k).zip(of(0)).map(|(axis, mean)| axis - mean).collect());
    Ok(std::iter::once(of(0).collect()).chain(added).collect())
}
