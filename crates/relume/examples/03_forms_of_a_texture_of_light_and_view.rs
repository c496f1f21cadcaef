//! Bytes and errors of the forms in which a texture of light and view can be kept: factorisations, clusters, reflectance models,
//! functions for each view, and random fields. Prints a table and writes the curve `03_rates.svg` into the current folder.
//!
//! `cargo run --release --example 03_forms_of_a_texture_of_light_and_view -- wool.zip` measures a set of photographs; without
//! one it is a built-in weave under a virtual gonioreflectometer. Errors are root mean squares of encoded values of 255, and
//! mean differences in CIE Lab, over at most 400 of the photographs; files are in halves.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use relume::capture::dome::sampling::{all_pairs, spread_directions};
use relume::capture::dome::{Dome, DomeOptions, Gonioreflectometer};
use relume::direction::Directions;
use relume::fit::learned::{self, ClusterOptions, LearnedOptions, Rank};
use relume::fit::parametric::{self, ParametricForm, ParametricOptions};
use relume::format::bonn::{BtfScalar, encode_dfmf, encode_pvf};
use relume::format::exr::{encode_clustered, encode_parametric};
use relume::format::{ExrDepth, FieldFormat, encode_field, rlm};
use relume::metric::lab_errors;
use relume::procedural::{Material, MaterialOptions};
use relume::random_field::{ModelOptions, character};
use relume::workflow::capture::PhotographFormat;
use relume::workflow::decorrelated::{DECORRELATED, DecorrelatedRanks, decorrelated};
use relume::workflow::gonioreflectometer::images;
use relume::workflow::image_clusters::{ImageClusterRequest, model_image_clusters};
use relume::workflow::model::ModelRequest;
use relume::workflow::per_view::per_view;
use relume::workflow::{Btf, Missing};
use relume::{Error, Job, Picture, Result, Size, Space, relight};

/// The most photographs that are compared.
const COMPARED: usize = 400;

/// A form of the texture: its family, what it is, the bytes of its file, and its errors where texels correspond.
struct Form {
    family: &'static str,
    name: String,
    bytes: usize,
    errors: Option<[f64; 2]>,
}

/// The photographs, and what is common to all forms.
struct Photographs {
    btf: Btf,
    pairs: Vec<(String, Directions)>,
    scratch: PathBuf,
    job: Job,
}

fn main() -> Result<()> {
    let scratch = std::env::temp_dir().join(format!("relume-03-{}", std::process::id()));
    let given = std::env::args().nth(1).map(PathBuf::from);
    let made = given.map_or_else(|| virtual_set(&scratch.join("weave")), Ok);
    let result = made.and_then(|path| measured(&path, &scratch));
    let _ = std::fs::remove_dir_all(&scratch);
    result
}

/// Images of a built-in material for all pairs of 14 lights and 14 views.
fn virtual_set(folder: &Path) -> Result<PathBuf> {
    let job = Job::default();
    let material = MaterialOptions { size: Size::new(32, 32), feature: 8.0, ..MaterialOptions::default() };
    let dome = Dome::new(Material::Weave.make(&material, &job)?, &DomeOptions::default(), &job)?;
    let pairs = all_pairs(&spread_directions(14, 1), &spread_directions(14, 2));
    let device = Gonioreflectometer::new(dome, pairs, &job)?;
    images(&device, PhotographFormat::Png, &job, &mut |name, bytes| {
        let path = folder.join(name);
        let written = path.parent().map_or(Ok(()), std::fs::create_dir_all);
        written
            .and_then(|()| std::fs::write(&path, bytes))
            .map_err(|e| Error::io("cannot write", &e).at(path))
    })?;
    Ok(folder.to_path_buf())
}

fn measured(path: &Path, scratch: &Path) -> Result<()> {
    let job = Job::default();
    std::fs::create_dir_all(scratch).map_err(|e| Error::io("cannot create the folder", &e).at(scratch))?;
    let btf = Btf::open(path, Missing::Refuse, &job)?;
    let first = btf.photograph(0, &job)?;
    let bytes = (first.size().texels() * first.channels() * btf.list().entries.len()) as f64;
    let pairs = btf.pairs();
    let set = Photographs { btf, pairs, scratch: scratch.to_path_buf(), job };
    println!("{} photographs of {}, {bytes} bytes\n", set.pairs.len(), first.size());
    println!("| form | bytes | 1 to | RMSE of 255 | dB | CIE Lab |\n|---|---|---|---|---|---|");
    let mut forms = Vec::new();
    let mut note = |form: Form| {
        let errors = form.errors.map_or("| | |".to_owned(), |[rmse, lab]| {
            format!("| {:.2} | {:.2} | {lab:.2} |", 255.0 * rmse, -20.0 * rmse.log10())
        });
        println!("| {} | {} | {:.0} {errors}", form.name, form.bytes, bytes / form.bytes as f64);
        forms.push(form);
    };
    let most = first.size().texels().min(set.pairs.len() * first.channels());
    let ranks: Vec<usize> = [4, 8, 16, 32, 64].into_iter().filter(|rank| rank * 3 < most).collect();
    for &rank in &ranks {
        note(set.common(rank)?);
    }
    for &rank in ranks.iter().filter(|rank| **rank <= 32) {
        note(set.decorrelated(rank)?);
    }
    for rank in [1, 2, 4] {
        note(set.of_each_view(rank)?);
    }
    for (&rank, clusters) in ranks.iter().rev().take(2).zip([32, 16]) {
        note(set.clustered(rank, clusters)?);
    }
    for name in
        ["lafortune1", "lafortune2", "ggx", "views-ptm", "views-lafortune1", "separable2", "separable4"]
    {
        note(set.reflectance(name)?);
    }
    note(set.random_field()?);
    note(set.image_clusters()?);
    let svg = curve(&forms, bytes);
    std::fs::write("03_rates.svg", svg).map_err(|e| Error::io("cannot write", &e).at("03_rates.svg"))
}

impl Photographs {
    /// The root mean square error of encoded values, and the mean difference in Lab.
    fn errors(&self, picture: &dyn Fn(Directions) -> Result<Picture>) -> Result<[f64; 2]> {
        let step = self.pairs.len().div_ceil(COMPARED);
        let (mut squares, mut values, mut lab, mut pictures) = (0.0, 0.0, 0.0, 0.0);
        for i in (0..self.pairs.len()).step_by(step) {
            let truth = self.btf.photograph(i, &self.job)?.to_picture(Space::Srgb);
            let mut shown = picture(self.pairs[i].1)?.to_space(Space::Srgb);
            shown.planes.as_mut_slice().iter_mut().for_each(|v| *v = v.clamp(0.0, 1.0));
            let both = truth.planes.as_slice().iter().zip(shown.planes.as_slice());
            squares += both.map(|(a, b)| f64::from(a - b).powi(2)).sum::<f64>();
            values += truth.planes.as_slice().len() as f64;
            lab += lab_errors(&truth, &shown)?.mae_lab;
            pictures += 1.0;
        }
        Ok([(squares / values).sqrt(), lab / pictures])
    }

    fn learned(&self, rank: usize, clusters: Option<ClusterOptions>) -> Result<learned::LearnedFit> {
        let options = LearnedOptions { rank: Rank::Functions(rank), clusters, ..LearnedOptions::default() };
        learned::fit(&self.pairs, &|i| self.btf.photograph(i, &self.job), &options, &self.job)
    }

    fn common(&self, rank: usize) -> Result<Form> {
        let field = self.learned(rank, None)?.field;
        let bytes = encode_field(&field, FieldFormat::Exr(ExrDepth::Half), None, &self.job)?.len();
        let errors = Some(self.errors(&|pair| Ok(relight(&field, pair)))?);
        Ok(Form { family: "common functions", name: format!("{rank} common functions (FMF)"), bytes, errors })
    }

    fn clustered(&self, rank: usize, clusters: usize) -> Result<Form> {
        let axes = (rank / 3).max(1);
        let fit = self.learned(rank, Some(ClusterOptions { clusters, axes }))?;
        let clustered = fit.clustered.as_ref().ok_or_else(|| Error::invalid("no clusters were made"))?;
        let bytes = encode_clustered(clustered, ExrDepth::Half, &self.job)?.len();
        let errors = Some(self.errors(&|pair| Ok(relight(&fit.field, pair)))?);
        let name = format!("{rank} functions, {clusters} clusters of {axes} axes");
        Ok(Form { family: "clusters", name, bytes, errors })
    }

    /// The errors of a `.btf` file.
    fn of_file(&self, family: &'static str, name: String, file: &[u8]) -> Result<Form> {
        let path = self.scratch.join("form.btf");
        std::fs::write(&path, file).map_err(|e| Error::io("cannot write", &e).at(&path))?;
        let other = Btf::open(&path, Missing::Refuse, &self.job)?;
        let errors = Some(self.errors(&|pair| other.relit(pair, &self.job))?);
        Ok(Form { family, name, bytes: file.len(), errors })
    }

    fn directions(&self) -> Vec<Directions> {
        self.pairs.iter().map(|(_, pair)| *pair).collect()
    }

    fn decorrelated(&self, rank: usize) -> Result<Form> {
        let ranks = DecorrelatedRanks::of_luminance(rank);
        let load = |i: usize| self.btf.photograph(i, &self.job);
        let factors = decorrelated(&self.pairs, &load, ranks, &self.job)?;
        let file = encode_dfmf(&self.directions(), &factors, DECORRELATED, BtfScalar::Half, &self.job)?;
        let name = format!("{rank} of the luminance, {} of each colour difference (DFMF)", ranks.color);
        self.of_file("decorrelated", name, &file)
    }

    fn of_each_view(&self, rank: usize) -> Result<Form> {
        let views = per_view(&self.pairs, &|i| self.btf.photograph(i, &self.job), rank, &self.job)?;
        let file = encode_pvf(&self.directions(), &views, BtfScalar::Half, &self.job)?;
        self.of_file("per view", format!("{rank} functions of each view (PVF)"), &file)
    }

    fn reflectance(&self, name: &str) -> Result<Form> {
        let form = ParametricForm::from_name(name, Space::Srgb);
        let form = form.ok_or_else(|| Error::usage(format!("there is no model {name}")))?;
        let family = if matches!(form, ParametricForm::PerView(_)) { "views" } else { "models" };
        let load = |i: usize| self.btf.photograph(i, &self.job);
        let field = parametric::fit(&self.pairs, &load, &ParametricOptions::of(form), &self.job)?.field;
        let bytes = encode_parametric(&field, ExrDepth::Half, &self.job)?.len();
        let errors = Some(self.errors(&|pair| field.picture(pair, &self.job))?);
        Ok(Form { family, name: format!("{name}, {} numbers", field.planes().count()), bytes, errors })
    }

    /// One model of all functions.
    fn random_field(&self) -> Result<Form> {
        let request = ModelRequest::default();
        let field = self.learned(request.functions, None)?.field;
        let kind = character(&field, &self.job)?;
        let bytes = rlm::encode(&request.fit(&field, &kind, &self.job)?.model)?.len();
        Ok(Form { family: "random fields", name: "joint random field".to_owned(), bytes, errors: None })
    }

    fn image_clusters(&self) -> Result<Form> {
        let options = ModelOptions::default();
        let request = ImageClusterRequest { options, ..ImageClusterRequest::default() };
        let load = |i: usize| self.btf.photograph(i, &self.job);
        let made = model_image_clusters(&self.pairs, &load, &request, &self.job)?;
        let bytes = rlm::encode(&made.model)?.len();
        let name = format!("random fields of {} clusters of photographs", made.report.photographs.len());
        Ok(Form { family: "random fields", name, bytes, errors: None })
    }
}

/// The errors against the ratios, whose axis is logarithmic; forms that are made anew are marked below.
fn curve(forms: &[Form], bytes: f64) -> String {
    const COLORS: [(&str, &str); 7] = [
        ("common functions", "#1f5fa8"),
        ("decorrelated", "#3a9"),
        ("per view", "#a3c"),
        ("clusters", "#c63"),
        ("models", "#222"),
        ("views", "#c33"),
        ("random fields", "#777"),
    ];
    let ratio = |form: &Form| bytes / form.bytes as f64;
    let [low, high] = [f64::min, f64::max].map(|pick| {
        let first = forms.first().map_or(1.0, ratio);
        forms.iter().map(ratio).fold(first, pick).ln()
    });
    let most = forms.iter().filter_map(|f| f.errors).map(|[rmse, _]| 255.0 * rmse).fold(1.0, f64::max);
    let x = |form: &Form| 60.0 + 440.0 * (ratio(form).ln() - low) / (high - low).max(1e-9);
    let y = |rmse: f64| 350.0 - 320.0 * 255.0 * rmse / most;
    let mut svg = "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 640 400\" font-family=\"sans-serif\" \
                   font-size=\"12\">\n<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n<path d=\"M60 20V350H510\" \
                   fill=\"none\" stroke=\"#888\"/>\n"
        .to_owned();
    for (row, (family, color)) in COLORS.iter().enumerate() {
        let own: Vec<&Form> = forms.iter().filter(|form| form.family == *family).collect();
        let place = |form: &&Form| (x(form), form.errors.map_or(358.0, |[rmse, _]| y(rmse)));
        let points: Vec<String> = own.iter().map(&place).map(|(x, y)| format!("{x:.1},{y:.1}")).collect();
        if *family != "models" && *family != "random fields" && *family != "views" {
            let _ =
                writeln!(svg, "<polyline points=\"{}\" fill=\"none\" stroke=\"{color}\"/>", points.join(" "));
        }
        for (form, (x, y)) in own.iter().map(|f| (f, place(f))) {
            let _ = writeln!(
                svg,
                "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3.5\" fill=\"{color}\"><title>{}, 1 to {:.0}</title></circle>",
                form.name,
                ratio(form)
            );
        }
        let line = 30 + 18 * row;
        let _ = writeln!(svg, "<text x=\"520\" y=\"{line}\" fill=\"{color}\">{family}</text>");
    }
    let _ = writeln!(
        svg,
        "<text x=\"52\" y=\"34\" text-anchor=\"end\">{most:.0}</text><text x=\"52\" y=\"354\" text-anchor=\"end\">0</text>\
         <text x=\"60\" y=\"376\">1:{:.0}</text><text x=\"500\" y=\"376\" text-anchor=\"end\">1:{:.0}</text>\
         <text x=\"280\" y=\"392\" text-anchor=\"middle\">RMSE of 255 against the bytes of the photographs to those of the \
         file</text></svg>",
        low.exp(),
        high.exp()
    );
    svg
}
