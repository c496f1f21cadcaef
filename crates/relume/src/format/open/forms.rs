//! Files as they are where they are no texture of functions: other forms, outlines, and descriptions of folders.

use std::path::{Path, PathBuf};

use super::Opened;
use crate::error::{Error, Result};
use crate::field::{NonlinearField, ParametricField};
use crate::fit::parametric::linear_remark;
use crate::format::content::Content;
use crate::format::exr::{self, ExrDepth};
use crate::format::field_file::FieldFile;
use crate::format::map_role::MapRole;
use crate::format::outline::{self, FileOutline};
use crate::format::picture::PictureFormat;

impl Opened {
    /// What a file for other programs holds, or a page with textures, if it is one.
    ///
    /// # Errors
    /// The error names the file: one that is damaged.
    pub fn outline(&self) -> Result<Option<FileOutline>> {
        match self.content {
            Content::Mesh | Content::Array | Content::Unknown => outline::outline(&self.bytes),
            Content::Capture if self.name.is_dir() => outline::of_folder(&self.name),
            _ => Ok(None),
        }
        .map_err(|e| e.at(&self.name))
    }

    /// The texture as it is, if it is not linear in the numbers of texels, and the type of its samples: [`Opened::into_field`]
    /// gives its linear form.
    ///
    /// # Errors
    /// The error names the file: one that is damaged or exceeds the limits.
    pub fn nonlinear(&self) -> Result<Option<(NonlinearField, ExrDepth)>> {
        if self.content != Content::Field {
            return Ok(None);
        }
        exr::nonlinear(&self.bytes, &self.job).map_err(|e| e.at(&self.name))
    }

    /// The reflectance models of the texels, if the file holds such a texture: [`Opened::into_field`] gives its linear form.
    ///
    /// # Errors
    /// As [`Opened::nonlinear`].
    pub fn parametric(&self) -> Result<Option<ParametricField>> {
        // Clusters would be read twice: most verbs take their linear form.
        if !exr::holds_models(&self.bytes) {
            return Ok(None);
        }
        Ok(self.nonlinear()?.and_then(|(field, _)| match field {
            NonlinearField::Models(models) => Some(models),
            NonlinearField::Clusters(_) => None,
        }))
    }
}

impl FieldFile {
    /// What is to be said where the field stands for reflectance models.
    pub fn linear_remark(&self) -> Option<String> {
        self.models.as_ref().map(|of| linear_remark(&of.models, &self.field, of.rmse))
    }

    /// What is to be said where the field serves to compare texels, and the numbers of the models are kept.
    pub fn comparison_remark(&self) -> Option<String> {
        self.models.as_ref().map(|of| {
            format!(
                "texels of the reflectance model {} are compared by {} learned functions, which differ from what it shows by {:.2} of \
                 255 (root mean square)",
                of.models.model().name(),
                self.field.basis().len(),
                255.0 * of.rmse
            )
        })
    }
}

/// What to do with a folder where one file is expected.
pub(super) fn hint_of_folder(folder: &Path) -> &'static str {
    let files: Vec<PathBuf> =
        std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path()).collect();
    let is_map = |path: &PathBuf| {
        PictureFormat::from_path(path).is_ok() && !matches!(MapRole::of_name(path), MapRole::Other)
    };
    if files.is_empty() {
        "; it is empty"
    } else if files.iter().any(is_map) {
        "; it seems to hold maps: `relume tileable`, `synth` and `maps` take the folder, other verbs one of its files"
    } else {
        ""
    }
}

/// The files that describe the texture of a folder.
const DESCRIPTIONS: [&str; 2] = ["info.json", "info.xml"];

/// Whether a file is named as the description of a folder.
pub(super) fn is_description(path: &Path) -> bool {
    path.file_name().is_some_and(|name| DESCRIPTIONS.iter().any(|of| name == *of))
}

/// The description in a folder that is no texture.
pub(super) fn description_in(folder: &Path) -> Option<PathBuf> {
    DESCRIPTIONS.iter().map(|name| folder.join(name)).find(|path| path.is_file())
}

/// The error for a description that none of the layouts of web folders has.
pub(super) fn describes_nothing(path: &Path) -> Error {
    let expected = match path.extension().is_some_and(|e| e == "xml") {
        true => "the element MultiRes, as the older web RTI viewer has it",
        false => "the numbers of the functions, as Relight and OpenLIME have them",
    };
    Error::invalid(format!("the file describes no texture: expected {expected}"))
}
