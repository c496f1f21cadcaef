//! The opacity of exemplars: transparent texels are not copied, and the outputs keep the opacity of the others.

use std::path::Path;

use relume::field::ReflectanceField;
use relume::format::FieldFile;
use relume::synthesis::{SourceMap, gather};
use relume::{Picture, Planes, Result, Space};

use crate::context::Context;

/// The texels of an exemplar that may not be used: those of a mask, and those that are transparent, which is
/// said.
pub fn excluded(
    file: &FieldFile,
    path: &Path,
    mask: Option<Vec<bool>>,
    context: &Context,
) -> Option<Vec<bool>> {
    let Some(opacity) = &file.opacity else { return mask };
    let opacity = opacity.plane(0);
    let transparent = opacity.iter().filter(|&&opacity| opacity == 0.0).count();
    let partly = opacity.iter().filter(|&&opacity| opacity > 0.0 && opacity < 1.0).count();
    let job = context.job.about(path);
    if transparent > 0 {
        job.remark(format!("{transparent} texels are transparent (alpha 0) and are not copied"));
    }
    if partly > 0 {
        job.remark(format!(
            "{partly} texels are partly transparent and are copied like opaque ones, with their opacity"
        ));
    }
    match (mask, file.transparent()) {
        (Some(mask), Some(transparent)) => Some(mask.iter().zip(transparent).map(|(a, b)| *a || b).collect()),
        (mask, transparent) => mask.or(transparent),
    }
}

/// The opacity made by applying a map to files, if one of them has any.
pub fn gathered(map: &SourceMap, files: &[FieldFile], context: &Context) -> Result<Option<Planes>> {
    if files.iter().all(|file| file.opacity.is_none()) {
        return Ok(None);
    }
    let opaque = |file: &FieldFile| {
        let texels = file.field.size().texels();
        Planes::from_vec(file.field.size(), 1, vec![1.0; texels])
    };
    let fields = files.iter().map(|file| {
        let planes = file.opacity.clone().map_or_else(|| opaque(file), Ok)?;
        Ok(ReflectanceField::from_picture(Picture { planes, space: Space::Linear }))
    });
    let fields = fields.collect::<Result<Vec<_>>>()?;
    let fields: Vec<&ReflectanceField> = fields.iter().collect();
    Ok(Some(gather(map, &fields, &context.job)?.coefficients().clone()))
}
