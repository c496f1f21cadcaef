//! Models of clusters of photographs: `--fields clusters`.

use std::fmt::Write;

use relume::field::{PlaneLayout, ReflectanceField};
use relume::format::rlm;
use relume::random_field::{Character, character, curves};
use relume::workflow::image_clusters::{
    ImageClusterReport, ImageClusterRequest, RangeReport, model_image_clusters,
};
use relume::workflow::model::ModelRequest;
use relume::workflow::{Btf, Missing};
use relume::{Error, RasterSequence, Result, Space};
use serde_json::json;

use super::{Args, describe, request};
use crate::context::Context;
use crate::output::Outputs;
use crate::report::{Report, counted};

/// Groups the photographs, models the picture of each cluster and the range map, and writes the model.
pub(super) fn run(args: &Args, mut outputs: Outputs, context: &Context) -> Result<Report> {
    let job = &context.job;
    let request = cluster_request(args)?;
    let btf = Btf::open(&args.texture, Missing::Refuse, job)?;
    let (pairs, load) = (btf.pairs(), |i: usize| btf.photograph(i, job));
    let photographs = RasterSequence::open(&load)?;
    let load = |i: usize| photographs.read(i);
    let at = |e: Error| e.at(&args.texture);
    let made = model_image_clusters(&pairs, &load, &request, job).map_err(at)?;
    outputs.write(&args.output, rlm::encode(&made.model)?)?;
    if let Some(path) = &args.curve {
        outputs.write(path, curves::svg(&made.levels.concat()).into_bytes())?;
    }
    let written = outputs.commit()?;
    let largest =
        (0..made.report.photographs.len()).max_by_key(|&k| (made.report.photographs[k], usize::MAX - k));
    let picture = largest.map(|k| &made.report.pictures[k]);
    let number = pairs.iter().position(|(name, _)| Some(name) == picture).unwrap_or(0);
    let kind = suited(&load, number, context)?;
    let mut report = describe(&made.model)?;
    let _ = write!(report.text, "\n{}\n{kind}", said(&made.report));
    report.json["likeness"] = json!(null);
    report.json["clustering"] = json!(made.report);
    report.json["character"] = json!(kind);
    report.json["estimation"] = json!(made.levels);
    let regular = kind.is_regular().then(|| {
        "the photographs are regular: random fields lose what repeats, which is left to the range map; `relume model` without \
         --fields keeps it in one joint model"
            .to_owned()
    });
    Ok(report.with_outputs(written).with_warnings(regular))
}

/// The checked request.
fn cluster_request(args: &Args) -> Result<ImageClusterRequest> {
    if !Btf::is_at(&args.texture) {
        return Err(Error::usage(
            "clusters are of photographs under light and view: name a folder, .zip or .btf of them",
        )
        .at(&args.texture));
    }
    let given =
        [("--functions", args.functions.is_some()), ("--function-bytes", args.function_bytes.is_some())];
    if let Some((name, _)) = given.into_iter().find(|(_, given)| *given) {
        return Err(Error::usage(format!(
            "{name} is of learned functions, and clusters of photographs have none: leave it out"
        )));
    }
    let of_range = request(args)?;
    let defaults = ImageClusterRequest::default();
    let request = ImageClusterRequest {
        clusters: args.lights.image_clusters.unwrap_or(defaults.clusters),
        options: of_range.options,
        range: (!args.lights.no_range).then_some(ModelRequest { ..of_range }),
        ..defaults
    };
    request.validate()?;
    Ok(request)
}

/// Whether a random field suits the photographs, judged by one of them.
fn suited(load: &relume::raster::LoadRaster, number: usize, context: &Context) -> Result<Character> {
    let picture = load(number)?.to_picture(Space::Srgb);
    let field = ReflectanceField::from_picture(picture);
    debug_assert!(*field.layout() == PlaneLayout::RGB || *field.layout() == PlaneLayout::LUMINANCE);
    character(&field, &context.job)
}

/// How the photographs were grouped.
fn said(report: &ImageClusterReport) -> String {
    let sizes: Vec<String> = report.photographs.iter().map(usize::to_string).collect();
    let mut text = format!(
        "{} of {} ({}), by {} of their colours\nwith the photographs of the clusters instead of \
         made ones: {:.2} dB, RMSE {:.4} ({:.2} of 255)",
        counted(sizes.len(), "cluster"),
        counted(report.photographs.iter().sum::<usize>(), "photograph"),
        sizes.join(", "),
        counted(report.components, "component"),
        report.table_psnr_db,
        report.table_rmse,
        255.0 * report.table_rmse
    );
    if let Some(RangeReport { photographs, range: [low, high], regularity, tile }) = &report.range {
        let how = match tile {
            Some([width, height]) => format!("a structure of {width} x {height} texels"),
            None => "a random field".to_owned(),
        };
        let _ = write!(
            text,
            "\nrange map from {}: {low:.1} to {high:.1} texels, regularity {regularity:.2}, {how}",
            counted(*photographs, "photograph")
        );
    }
    text
}
