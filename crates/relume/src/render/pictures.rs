//! Textures that have a picture for each light and view: functions, and reflectance models as they are.

use super::relighter::Relighter;
use crate::direction::Directions;
use crate::error::Result;
use crate::field::{Basis, ParametricField, ReflectanceField};
use crate::job::Job;
use crate::picture::Picture;
use crate::size::Size;

/// A texture to be shown, whatever its form.
#[derive(Debug, Clone, Copy)]
pub enum ShownForm<'a> {
    /// Functions of light, or of light and view.
    Field(&'a ReflectanceField),
    /// Reflectance models.
    Models(&'a ParametricField),
}

/// A texture prepared for pictures under many lights and views.
#[derive(Debug)]
pub enum Pictures<'a> {
    /// Functions.
    Field(Box<Relighter<'a>>),
    /// Reflectance models.
    Models(&'a ParametricField),
}

impl<'a> ShownForm<'a> {
    /// Width and height.
    pub fn size(self) -> Size {
        match self {
            Self::Field(field) => field.size(),
            Self::Models(models) => models.size(),
        }
    }

    /// The channels of a picture.
    pub fn channels(self) -> usize {
        match self {
            Self::Field(field) => field.layout().channels(),
            Self::Models(models) => models.channels(),
        }
    }

    /// Whether pictures differ with the view.
    pub fn depends_on_view(self) -> bool {
        match self {
            Self::Field(field) => field.basis().depends_on_view(),
            Self::Models(_) => true,
        }
    }

    /// Whether all pictures are one.
    pub fn is_constant(self) -> bool {
        matches!(self, Self::Field(field) if *field.basis() == Basis::Constant)
    }

    /// Prepares it.
    ///
    /// # Errors
    /// Limits exceeded, and a cancelled job.
    pub fn pictures(self, job: &Job) -> Result<Pictures<'a>> {
        Ok(match self {
            Self::Field(field) => Pictures::Field(Box::new(Relighter::new(field, job)?)),
            Self::Models(models) => Pictures::Models(models),
        })
    }
}

impl Pictures<'_> {
    /// The picture for a light and a view, in the space of the texture.
    ///
    /// # Errors
    /// Limits exceeded, and a cancelled job.
    pub fn picture(&self, directions: impl Into<Directions>, job: &Job) -> Result<Picture> {
        match self {
            Self::Field(relighter) => job.proceed().map(|()| relighter.relight(directions)),
            Self::Models(models) => models.picture(directions, job),
        }
    }
}

impl<'a> From<&'a ReflectanceField> for ShownForm<'a> {
    fn from(field: &'a ReflectanceField) -> Self {
        Self::Field(field)
    }
}

impl<'a> From<&'a ParametricField> for ShownForm<'a> {
    fn from(models: &'a ParametricField) -> Self {
        Self::Models(models)
    }
}
