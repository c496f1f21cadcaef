//! Normals and colours of textures, whatever their form: of functions those of the brightest light, of reflectance models what
//! their numbers say.

use crate::direction::Direction;
use crate::error::{Error, Result};
use crate::field::{ParametricField, ReflectanceField, TexelModel};
use crate::fit::parametric::remarked_linear_form;
use crate::job::Job;
use crate::picture::Picture;
use crate::planes::Planes;
use crate::size::Size;
use crate::space::Space;
use crate::surface::{self, NormalDoubt};

/// What the normals and the colours of a texture come from.
#[derive(Debug)]
pub enum SurfaceForm {
    /// The brightest light of each texel, seen from straight above.
    Functions(ReflectanceField),
    /// The numbers of facets.
    Facets {
        /// Three planes of unit normals.
        normals: Planes,
        /// Base colours, linear.
        albedo: Picture,
    },
    /// Lobes, which have colours and no normals.
    Lobes {
        /// The picture under the light from straight above, under which each texel seen from there is brightest.
        albedo: Picture,
    },
}

impl SurfaceForm {
    /// Of reflectance models: functions for each view are taken as seen from straight above, exactly; lobes for each view by
    /// their linear form, with a remark.
    ///
    /// # Errors
    /// Limits exceeded, and a cancelled job.
    pub fn of_models(models: &ParametricField, job: &Job) -> Result<Self> {
        match models.model() {
            TexelModel::Ggx => Ok(Self::Facets {
                normals: facet_normals(models, job)?,
                albedo: Picture {
                    planes: models.planes().clone().truncated(models.channels()),
                    space: Space::Linear,
                },
            }),
            TexelModel::Lafortune { .. } => {
                Ok(Self::Lobes { albedo: models.picture(Direction::ZENITH, job)? })
            }
            TexelModel::PerView(_) | TexelModel::Separable(_) => match models.from_above(job)? {
                Some(functions) => Ok(Self::Functions(functions)),
                None => remarked_linear_form(models, job).map(Self::Functions),
            },
        }
    }

    /// Width and height.
    pub fn size(&self) -> Size {
        match self {
            Self::Functions(field) => field.size(),
            Self::Facets { normals, .. } => normals.size(),
            Self::Lobes { albedo } => albedo.size(),
        }
    }

    /// The channels of the colours.
    pub fn channels(&self) -> usize {
        match self {
            Self::Functions(field) => field.layout().channels(),
            Self::Facets { albedo, .. } | Self::Lobes { albedo } => albedo.planes.count(),
        }
    }

    /// Three planes of unit normals.
    ///
    /// # Errors
    /// Lobes, which have none.
    pub fn normals(&self) -> Result<Planes> {
        match self {
            Self::Functions(field) => Ok(surface::normals(field)),
            Self::Facets { normals, .. } => Ok(normals.clone()),
            Self::Lobes { .. } => Err(no_normals()),
        }
    }

    /// The colours without shading.
    pub fn albedo(&self) -> Picture {
        match self {
            Self::Functions(field) => surface::albedo(field),
            Self::Facets { albedo, .. } | Self::Lobes { albedo } => albedo.clone(),
        }
    }

    /// Why normals are not to be trusted.
    pub fn doubts(&self, normals: &Planes) -> Vec<NormalDoubt> {
        match self {
            Self::Functions(field) => surface::doubts(field, normals),
            Self::Facets { .. } | Self::Lobes { .. } => Vec::new(),
        }
    }
}

/// The error for lobes.
pub(super) fn no_normals() -> Error {
    Error::usage(
        "lobes of Lafortune have no normals, so that the surface would be flat: fit facets (--model ggx), which have, or learned \
         functions",
    )
}

/// The normals that the numbers of facets hold.
pub(super) fn facet_normals(models: &ParametricField, job: &Job) -> Result<Planes> {
    let mut normals = Planes::zeros_within(job, "the normals", models.size(), 3)?;
    let first = models.channels();
    (0..2).for_each(|axis| normals.plane_mut(axis).copy_from_slice(models.planes().plane(first + axis)));
    for texel in 0..models.size().texels() {
        let [x, y] = [0, 1].map(|axis| normals.plane(axis)[texel]);
        normals.plane_mut(2)[texel] = (1.0 - x * x - y * y).max(0.0).sqrt();
    }
    Ok(normals)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::parametric::examples::all;

    #[test]
    fn normals_of_facets_are_their_numbers_and_lobes_have_none() {
        let job = Job::default();
        for models in all() {
            let name = models.model().name();
            let form = SurfaceForm::of_models(&models, &job).unwrap();
            assert_eq!((form.size(), form.channels()), (models.size(), models.channels()), "{name}");
            assert_eq!(form.albedo().planes.count(), models.channels());
            if name.starts_with("lafortune") {
                assert!(form.normals().unwrap_err().to_string().contains("--model ggx"));
                continue;
            }
            let normals = form.normals().unwrap();
            for texel in 0..models.size().texels() {
                let length: f32 = (0..3).map(|k| normals.plane(k)[texel].powi(2)).sum();
                assert!((length - 1.0).abs() < 1e-4, "{name}: {length}");
            }
            if name == "ggx" {
                let numbers = models.planes().plane(models.channels());
                assert_eq!(normals.plane(0), numbers);
            }
        }
    }
}
