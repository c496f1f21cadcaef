//! The outputs of verbs with a source map besides the texture: the map itself, and the maps registered with
//! the texture, which by default have their say in the choice of texels, rearranged in the same way.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use relume::format::{FieldFile, FieldFormat, MapRole, NormalY};
use relume::surface::integrate::SurfaceBorder;
use relume::synthesis::{Boundary, SourceMap};
use relume::workflow::Btf;
use relume::workflow::map_set::{gather_map, join_heights, with_y_reversed};
use relume::workflow::tiling::MeasuredTiling;
use relume::{Error, ReflectanceField, Result};
use serde_json::json;

use crate::context::Context;
use crate::map_folder::{self, MapFolder};
use crate::output::Outputs;
use crate::rearranged_btf::AppliedBtf;
use crate::registered::{Applied, Registered, written_as};
use crate::report::Report;
use crate::{args, gathered, normals, output, paths};

/// Options for source maps and registered images.
#[derive(Debug, Clone, clap::Args)]
#[group(skip)]
pub struct Args {
    /// Also write the source of each texel, as x, y and exemplar: .npy or .exr
    #[arg(long, value_name = "FILE")]
    source_map: Option<PathBuf>,
    /// Maps registered with the exemplar (normals, height, roughness and so on, known by the words in their
    /// names): they are rearranged as the exemplar is, and all are compared together to choose texels. With
    /// several exemplars, one map for each in turn. Written as OUTPUT_IMAGE beside the output, or IMAGE in
    /// --apply-dir; a JPEG comes back as PNG, without further loss. The photographs of a texture of light and view (folder,
    /// .zip, .btf) are rearranged one by one into a .zip; they are not compared
    #[arg(long, value_name = "IMAGE", num_args = 1..)]
    apply: Vec<PathBuf>,
    /// As --apply, but without a say in the choice of texels
    #[arg(long, value_name = "IMAGE", num_args = 1..)]
    follow: Vec<PathBuf>,
    /// The folder for the images of --apply and --follow
    #[arg(long, value_name = "DIR")]
    apply_dir: Option<PathBuf>,
    /// The format of the images of --apply and --follow, by extension: png, tif, exr, jpg or ptm [default: that of
    /// each image, but png for JPEG]
    #[arg(long, value_name = "EXTENSION")]
    apply_format: Option<String>,
    /// Join height maps by their slopes instead of copying their texels: no cliffs at seams, heights change a
    /// little
    #[arg(long)]
    join_heights: bool,
    /// Write normal maps of --apply and --follow with Y up (OpenGL) or down (DirectX) [default: as they are]
    #[arg(long, value_parser = args::named::<NormalY>())]
    normal_y: Option<NormalY>,
    /// They are about a folder of maps, which may have no other than its colours.
    #[arg(skip)]
    is_of_set: bool,
}

/// A texture made of exemplars, or a map made of registered images.
pub struct Rearranged {
    /// Where it goes.
    pub output: PathBuf,
    /// The file, until it is written.
    pub bytes: Vec<u8>,
    /// How well it tiles, if it is to.
    tiling: Option<MeasuredTiling>,
}

impl Args {
    /// Takes the maps of a folder, to be written into `output` with their own names; returns where the colours go.
    ///
    /// # Errors
    /// Standard output, which is no folder.
    pub fn take_set(&mut self, set: &MapFolder, output: &Path) -> Result<PathBuf> {
        if output::is_stream(output) {
            return Err(Error::usage(
                "a folder of maps is written into a folder, not to standard output: name one",
            ));
        }
        self.apply.extend(set.compared.iter().cloned());
        self.follow.extend(set.followed.iter().cloned());
        self.apply_dir.get_or_insert_with(|| output.to_owned());
        self.is_of_set = true;
        Ok(set.output(output, self.apply_format.as_deref()))
    }

    /// Whether a source map and whether rearranged images are requested.
    pub fn given(&self) -> [(&'static str, bool); 3] {
        [
            ("--source-map", self.source_map.is_some()),
            ("--apply", !self.apply.is_empty()),
            ("--follow", !self.follow.is_empty()),
        ]
    }

    /// Claims all outputs of a command before the work; it reads `inputs` and also writes `named`, of which
    /// the first is the texture.
    pub fn claim(
        &self,
        inputs: &[&Path],
        named: &[&Path],
        exemplars: usize,
        outputs: &mut Outputs,
    ) -> Result<Vec<Applied>> {
        let images = self.apply.iter().chain(&self.follow).map(|path| &**path);
        let inputs: Vec<&Path> = inputs.iter().copied().chain(images).collect();
        if inputs.iter().filter(|path| output::is_stream(path)).count() > 1 {
            return Err(Error::usage("standard input can be read only once: give - for one input at most"));
        }
        let images = self.apply.iter().chain(&self.follow).filter(|path| !output::is_stream(path));
        if let Some(path) = images.clone().find(|path| !path.exists()) {
            return Err(Error::usage("there is no such file or folder to rearrange").at(path));
        }
        if let Some(path) = images.into_iter().find(|path| path.is_dir() && !Btf::is_at(path)) {
            return Err(Error::usage(
                "is a folder without photographs under light and view: name the images in it, or such a folder",
            )
            .at(path));
        }
        let jobs = self.jobs(named[0], exemplars)?;
        let all = named.iter().copied().chain(self.source_map.as_deref());
        for path in all.chain(jobs.iter().map(|job| job.output.as_path())) {
            outputs.file(path, &inputs)?;
        }
        let sets = self.btfs(named[0])?;
        if exemplars > 1 && !sets.is_empty() {
            return Err(Error::usage(
                "photographs of light and view are rearranged for one exemplar alone: leave out the others",
            )
            .at(&sets[0].input));
        }
        sets.iter().try_for_each(|set| outputs.file(&set.output, &inputs))?;
        if let Some(path) = &self.source_map {
            gathered::check_map(path)?;
        }
        let textures = jobs.iter().map(|job| job.output.as_path()).chain([named[0]]);
        for path in textures.filter(|path| !output::is_stream(path)) {
            FieldFormat::from_path(path)?;
        }
        Ok(jobs)
    }

    fn jobs(&self, output: &Path, exemplars: usize) -> Result<Vec<Applied>> {
        let lists = [("--apply", &self.apply, true), ("--follow", &self.follow, false)];
        let mut jobs = Vec::new();
        for (option, images, is_compared) in lists {
            let images: Vec<&PathBuf> = images.iter().filter(|path| !Btf::is_at(path)).collect();
            if !images.len().is_multiple_of(exemplars) {
                return Err(Error::usage(format!(
                    "{option} has {} images for {exemplars} exemplars: give one for each exemplar in turn",
                    images.len()
                )));
            }
            for images in images.chunks(exemplars) {
                let output = self.output_of(images[0], output)?;
                jobs.push(Applied {
                    images: images.iter().map(|path| (*path).clone()).collect(),
                    is_compared,
                    output,
                });
            }
        }
        let alone =
            [("--apply-dir", self.apply_dir.is_some()), ("--apply-format", self.apply_format.is_some())];
        let more = [("--normal-y", self.normal_y.is_some()), ("--join-heights", self.join_heights)];
        match alone.into_iter().chain(more).find(|(_, given)| *given) {
            Some((option, _)) if jobs.is_empty() && !self.is_of_set && self.btfs(output)?.is_empty() => {
                Err(Error::usage(format!("{option} is about the images of --apply and --follow: name some")))
            }
            _ => Ok(jobs),
        }
    }

    /// The sets of photographs under light and view among the images.
    pub fn btfs(&self, output: &Path) -> Result<Vec<AppliedBtf>> {
        let sets = self.apply.iter().chain(&self.follow).filter(|path| Btf::is_at(path));
        let applied = |path: &PathBuf| {
            Ok(AppliedBtf {
                input: path.clone(),
                output: self.output_of(path, output)?.with_extension("zip"),
            })
        };
        sets.map(applied).collect()
    }

    /// The path of a rearranged image.
    fn output_of(&self, image: &Path, output: &Path) -> Result<PathBuf> {
        let name = image.file_name().filter(|_| !output::is_stream(image));
        let name = name.ok_or_else(|| Error::usage("has no file name to call its output by").at(image))?;
        let path = match &self.apply_dir {
            Some(folder) => folder.join(name),
            None => {
                let stem = output.file_stem().filter(|_| !output::is_stream(output)).ok_or_else(|| {
                    Error::usage(
                        "--apply names its outputs after the output file: give a file or --apply-dir",
                    )
                })?;
                let mut joined = OsString::from(stem);
                joined.push("_");
                joined.push(name);
                output.with_file_name(joined)
            }
        };
        Ok(written_as(path, self.apply_format.as_deref()))
    }

    /// Refuses heights joined by their slopes.
    pub fn refuse_joined(&self, why: &str) -> Result<()> {
        match self.join_heights {
            true => Err(Error::usage(format!("--join-heights cannot be used: {why}"))),
            false => Ok(()),
        }
    }

    /// The texture made by applying a map to exemplars, the first of which has a name that says its meaning.
    pub fn texture(
        &self,
        map: &SourceMap,
        (files, name): (&[FieldFile], &Path),
        output: &Path,
        boundary: Boundary,
        context: &Context,
    ) -> Result<Rearranged> {
        let made = gathered::gather(map, files, name, context).map_err(|e| e.at(output))?;
        let tiling = (boundary == Boundary::Torus).then(|| MeasuredTiling::of_texture(made.coefficients()));
        let role = MapRole::of_name(name);
        // The exemplar's own record says that it holds normals: a name alone may be wrong.
        let y = files[0].record.normal_y.filter(|_| made.layout().channels() == 3);
        let bytes = gathered::encode_map(&made, map, (files, role, y), output, context);
        let bytes = bytes.map_err(|e| e.at(output))?;
        Ok(Rearranged { output: output.to_owned(), bytes, tiling })
    }

    /// The files made by applying a map to registered images.
    pub fn rearranged(
        &self,
        map: &SourceMap,
        registered: &[Registered],
        boundary: Boundary,
        context: &Context,
    ) -> Result<Vec<Rearranged>> {
        let file = |one: &Registered| {
            let output = one.applied.output.clone();
            let made = self.gathered(map, one, boundary, context)?;
            let measure = || MeasuredTiling::of_texture(made.coefficients());
            let tiling = (boundary == Boundary::Torus).then(measure);
            let bytes = self.encoded(&made, map, one, context).map_err(|e| e.at(&output))?;
            Ok(Rearranged { output, bytes, tiling })
        };
        registered.iter().map(file).collect()
    }

    /// A map made of the texels of registered images; normals with Y as it is to be written.
    pub fn gathered(
        &self,
        map: &SourceMap,
        of: &Registered,
        boundary: Boundary,
        context: &Context,
    ) -> Result<ReflectanceField> {
        let border = match boundary {
            Boundary::Open => SurfaceBorder::Open,
            Boundary::Torus => SurfaceBorder::Periodic,
        };
        let made = match of.applied.role() {
            MapRole::Height if self.join_heights => join_heights(map, &of.map(), border, &context.job),
            _ => gather_map(map, &of.map(), &context.job),
        };
        let made = made.map_err(|e| e.at(&of.applied.output))?;
        match of.is_normal_map() && self.written_y(of) != of.normal_y() {
            true => with_y_reversed(&made),
            false => Ok(made),
        }
    }

    /// The file of such a map, with what the images record.
    fn encoded(
        &self,
        made: &ReflectanceField,
        map: &SourceMap,
        of: &Registered,
        context: &Context,
    ) -> Result<Vec<u8>> {
        let y = of.is_normal_map().then(|| self.written_y(of));
        gathered::encode_map(made, map, (&of.files, of.applied.role(), y), &of.applied.output, context)
    }

    /// The direction of Y in which a normal map is written.
    fn written_y(&self, registered: &Registered) -> NormalY {
        self.normal_y.unwrap_or(registered.normal_y())
    }

    /// What is said of the images: which were compared, and the direction of normals.
    pub fn describe(&self, registered: &[Registered], mut report: Report) -> Report {
        for one in registered.iter().filter(|one| one.is_normal_map()) {
            let (path, y) = (&one.applied.output, self.written_y(one));
            if NormalY::of_name(path).is_some_and(|named| named != y) {
                report = report.with_warnings([format!(
                    "{}: the normals in it are {}, which its name contradicts: rename it for other programs",
                    path.display(),
                    y.in_words()
                )]);
            }
        }
        for one in registered {
            let role = match one.is_normal_map() {
                true => normals::described(self.written_y(one)),
                false => map_folder::in_words(&one.applied.images[0]),
            };
            let remark = if one.applied.is_compared { "" } else { ", not compared" };
            report.text.push_str(&format!("\n{}: {role}{remark}", one.applied.output.display()));
        }
        let images = registered.iter().map(|one| {
            json!({
                "output": paths::text(&one.applied.output),
                "role": one.applied.role(),
                "compared": one.applied.is_compared,
                "normal_y": one.is_normal_map().then(|| self.written_y(one)),
            })
        });
        if !registered.is_empty() {
            report.json["registered"] = images.collect();
        }
        report
    }

    /// The file of the source map, if requested.
    pub fn source_map(&self, map: &SourceMap, context: &Context) -> Result<Option<(PathBuf, Vec<u8>)>> {
        let encode = |path: &PathBuf| Ok((path.clone(), gathered::source_map(map, path, context)?));
        self.source_map.as_ref().map(encode).transpose()
    }
}

/// The report with how well each of several maps tiles, if they are to; warnings name those whose border may show.
pub fn with_tilings(mut report: Report, made: &[Rearranged]) -> Report {
    let tilings: Vec<_> = made.iter().filter_map(|one| Some((&one.output, one.tiling?))).collect();
    if tilings.len() < 2 {
        return report;
    }
    let json = tilings.iter().map(|(output, measured)| {
        json!({ "output": paths::text(output), "wrap": measured.wrap, "shows": measured.shows })
    });
    report.json["tiling"] = json.collect();
    let shows = tilings.iter().filter(|(_, measured)| measured.shows);
    let warnings: Vec<String> =
        shows.map(|(output, _)| format!("{} does not tile: its border may show", output.display())).collect();
    if warnings.is_empty() {
        report.text.push_str("\nevery map tiles");
    }
    report.with_warnings(warnings)
}
