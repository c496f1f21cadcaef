//! Textures that are not linear in the numbers of their texels: kept as they are in .exr, and otherwise as functions.

use relume::Result;
use relume::field::{NonlinearField, ParametricField};
use relume::format::exr::{decode_clustered, decode_parametric, encode_clustered, encode_parametric};
use relume::format::{ExrDepth, FieldFormat};
use relume::workflow::convert::RefitLoss;
use relume::workflow::convert_models::{convert_models, shown_loss};
use serde_json::{Value, json};

use super::{ConvertedPlace, Target, changed, report};
use crate::report::Report;

/// Writes the numbers as they are, in the type of samples asked for or that of the file.
pub(super) fn keep(own: &NonlinearField, stored: ExrDepth, place: ConvertedPlace<'_>) -> Result<Report> {
    let ConvertedPlace { args, target, mut outputs, context, .. } = place;
    let depth =
        if target == Target::File(FieldFormat::Exr(ExrDepth::Half)) { ExrDepth::Half } else { stored };
    let job = &context.job;
    let rounds = depth == ExrDepth::Half && stored == ExrDepth::Float;
    let (bytes, loss) = match own {
        NonlinearField::Models(models) => {
            let bytes = encode_parametric(models, depth, job)?;
            let loss = || shown_loss(models, &decode_parametric(&bytes, job)?, job);
            let loss = rounds.then(loss).transpose()?;
            (bytes, loss)
        }
        NonlinearField::Clusters(clusters) => {
            let bytes = encode_clustered(clusters, depth, job)?;
            let read = || decode_clustered(&bytes, job)?.expanded(job);
            let loss = || shown_loss(&clusters.expanded(job)?, &read()?, job);
            let loss = rounds.then(loss).transpose()?;
            (bytes, loss)
        }
    };
    outputs.write(&args.output, bytes)?;
    let what = own_in_words(own);
    let lost = match loss {
        None => "the same numbers".to_owned(),
        Some(loss) => changed("32-bit floats", loss),
    };
    let text = format!("{}: {}, {what}; {lost}", args.output.display(), own.size());
    let json = json!({
        "width": own.size().width,
        "height": own.size().height,
        "form": described(own),
        "from": described(own),
        "loss": loss,
    });
    Ok(Report::new(text, json).with_outputs(outputs.commit()?))
}

/// Converts reflectance models to functions; the loss is that of what the models themselves show.
pub(super) fn convert(models: &ParametricField, place: ConvertedPlace<'_>) -> Result<Report> {
    let job = &place.context.job;
    let made = convert_models(models, &place.options(None), job).map_err(|e| e.at(&place.args.file))?;
    let output = &place.args.output;
    let loss = |made: &relume::ReflectanceField| shown_loss(models, made, job);
    let (loss, written) = place.write(&made, None, loss)?;
    let from = format!("the reflectance model {}", models.model().name());
    let lost = loss.map_or(String::new(), |loss: RefitLoss| changed(&from, loss));
    let from = json!({ "model": models.model().name() });
    Ok(report(output, &made, &lost, from, loss).with_outputs(written))
}

fn own_in_words(own: &NonlinearField) -> String {
    match own {
        NonlinearField::Models(models) => {
            format!(
                "reflectance model {}, {} numbers a texel",
                models.model().name(),
                models.planes().count()
            )
        }
        NonlinearField::Clusters(clusters) => format!(
            "{} functions in {} clusters of {} axes",
            clusters.basis().len(),
            clusters.spaces().clusters(),
            clusters.spaces().axes()
        ),
    }
}

fn described(own: &NonlinearField) -> Value {
    match own {
        NonlinearField::Models(models) => json!({ "model": models.model().name() }),
        NonlinearField::Clusters(clusters) => json!({
            "basis": clusters.basis(),
            "clusters": clusters.spaces().clusters(),
            "cluster_axes": clusters.spaces().axes(),
            "space": clusters.space(),
        }),
    }
}
