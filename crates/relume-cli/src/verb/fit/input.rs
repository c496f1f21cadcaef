//! The photographs of a fit, with their directions: a capture, or a texture of light and view.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use relume::capture::Capture;
use relume::direction::{Direction, Directions};
use relume::field::Basis;
use relume::format::{FieldFormat, set_ending};
use relume::lamps::LampPositions;
use relume::workflow::Btf;
use relume::{Error, Job, Raster, Rect, Result, Size};

use super::Args;
use super::choice::BasisChoice;
use crate::context::Context;
use crate::output;
use crate::photographs::{PhotographArgs, PhotographSet};
use crate::report::counted;

/// Photographs that are read one at a time.
pub(super) struct Inputs {
    place: PathBuf,
    pairs: Vec<(String, Directions)>,
    warnings: Vec<String>,
    source: PhotographSource,
}

enum PhotographSource {
    Capture(Box<PhotographSet>),
    /// The numbers of its photographs that take part.
    Btf {
        btf: Box<Btf>,
        chosen: Vec<usize>,
        crop: Option<Rect<usize>>,
    },
}

impl Inputs {
    /// Locates the photographs, and refuses an output that is one of them.
    pub(super) fn open(args: &Args, is_btf: bool, basis: &BasisChoice, context: &Context) -> Result<Self> {
        if is_btf { Self::of_btf(args, basis, context) } else { Self::of_capture(args, context) }
    }

    fn of_capture(args: &Args, context: &Context) -> Result<Self> {
        refuse_archive(&args.capture)?;
        let is_texture = FieldFormat::from_path(&args.capture).is_ok() && args.capture.is_file();
        if is_texture {
            return Err(Error::usage(
                "is one texture or picture, and a fit is of photographs: name their .lp file or folder, or a .zip under light \
                 and view; `relume convert` makes other functions of a texture",
            )
            .at(&args.capture));
        }
        let set = PhotographSet::open(&args.capture, &args.photographs, args.mask.as_deref(), &context.job)?;
        let test = args.test.iter().filter_map(|path| Capture::open(path).ok());
        let tested: Vec<PathBuf> = test.flat_map(|capture| capture.photographs).map(|one| one.path).collect();
        let read: Vec<&Path> = set.paths().into_iter().chain(tested.iter().map(PathBuf::as_path)).collect();
        for written in std::iter::once(&args.output).chain(&args.report) {
            output::refuse_input(written, &read)?;
        }
        let pairs = set.lights().iter().map(|(name, light)| (name.clone(), (*light).into())).collect();
        let (place, warnings) = (set.capture.light_file.clone(), set.warnings.clone());
        Ok(Self { place, pairs, warnings, source: PhotographSource::Capture(Box::new(set)) })
    }

    fn of_btf(args: &Args, basis: &BasisChoice, context: &Context) -> Result<Self> {
        let crop = args.photographs.crop;
        let others = PhotographArgs { crop: None, ..args.photographs.clone() };
        if let Some(option) = others.given() {
            return Err(Error::usage(format!(
                "{option} is of captures of lights, and this is a texture of light and view"
            )));
        }
        let btf = Btf::open(&args.capture, args.missing.unwrap_or_default(), &context.job)?;
        output::refuse_input(&args.output, &btf.paths())?;
        let fills = args.needs_grid() && *basis == BasisChoice::Learned;
        let absent = btf.list().absent().map(|absent| filled(&absent, fills, args.hold_out.is_some()));
        let mut warnings: Vec<String> = absent.into_iter().collect();
        let btf = if fills { btf.filled() } else { btf };
        let mut pairs = btf.pairs();
        if *basis == BasisChoice::Learned {
            warnings.extend(constant(&pairs, true));
        }
        let mut chosen: Vec<usize> = (0..pairs.len()).collect();
        if *basis != BasisChoice::Learned {
            chosen = btf.frontal()?;
            warnings.push(format!(
                "the functions of {} depend on the light alone: {} of {} seen from straight above {} fitted; the basis learned \
                 holds all",
                basis.name(),
                chosen.len(),
                counted(pairs.len(), "photograph"),
                if chosen.len() == 1 { "is" } else { "are" }
            ));
            pairs = chosen.iter().map(|&i| pairs[i].clone()).collect();
        }
        context.job.check_bytes("the list of photographs", 256 * pairs.len() as u64)?;
        let place = btf.path().to_path_buf();
        Ok(Self {
            place,
            pairs,
            warnings,
            source: PhotographSource::Btf { btf: Box::new(btf), chosen, crop },
        })
    }

    /// As [`PhotographSet::measure`]; options for it are refused with textures of light and view.
    pub(super) fn measure(
        &mut self,
        args: &Args,
        foresee: &dyn Fn(Size, usize) -> Result<()>,
        job: &Job,
    ) -> Result<()> {
        let PhotographSource::Capture(set) = &mut self.source else { return Ok(()) };
        set.measure(&args.photographs, foresee, job)?;
        self.warnings.clone_from(&set.warnings);
        if args.basis == Some(BasisChoice::Learned) {
            self.warnings.extend(constant(&self.pairs, false));
        }
        Ok(())
    }

    /// What errors of the whole are about.
    pub(super) fn place(&self) -> &Path {
        &self.place
    }

    /// The name and directions of each photograph.
    pub(super) fn pairs(&self) -> &[(String, Directions)] {
        &self.pairs
    }

    /// Refuses single pairs of light and view where a grid of them is needed.
    pub(super) fn check_grid(&self, what: &str) -> Result<()> {
        match &self.source {
            PhotographSource::Btf { btf, .. } => btf.list().check_grid(what).map_err(|e| e.at(&self.place)),
            PhotographSource::Capture(_) => Ok(()),
        }
    }

    /// The number of distinct views.
    pub(super) fn views(&self) -> usize {
        distinct(self.pairs.iter().map(|(_, pair)| pair.view))
    }

    /// The number of distinct lights.
    pub(super) fn lights(&self) -> usize {
        distinct(self.pairs.iter().map(|(_, pair)| pair.light))
    }

    /// What is to be said of them.
    pub(super) fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// The lamps over the texels, where their places are known and the functions take the light of each texel from a
    /// direction of its own.
    pub(super) fn lamps(&self, basis: &Basis) -> Option<LampPositions> {
        match &self.source {
            PhotographSource::Capture(set) if !has_one_light(basis) => set.lamps(),
            _ => None,
        }
    }

    /// What is to be said where near lamps are taken from the middle of the surface.
    pub(super) fn lamp_warning(&self, basis: &Basis) -> Option<String> {
        let PhotographSource::Capture(set) = &self.source else { return None };
        (set.lamps().is_some() && has_one_light(basis)).then(|| {
            "photographs that are interpolated or learned from have one light each: that of near lamps is taken from the middle of \
             the surface"
                .to_owned()
        })
    }

    /// The texels that belong to the surface, where a mask says it.
    pub(super) fn mask(&self) -> Option<&[bool]> {
        match &self.source {
            PhotographSource::Capture(set) => set.mask(),
            PhotographSource::Btf { .. } => None,
        }
    }

    /// The photographs of a test, developed as these.
    pub(super) fn test_set(&self, path: &Path, args: &Args, job: &Job) -> Result<PhotographSet> {
        match &self.source {
            PhotographSource::Capture(set) => set.test_set(path, &args.photographs, job),
            PhotographSource::Btf { .. } => PhotographSet::open(path, &args.photographs, None, job),
        }
    }

    /// What is to be said of saturated photographs once all were read.
    pub(super) fn saturation(&self) -> Option<String> {
        match &self.source {
            PhotographSource::Capture(set) => set.saturation(),
            PhotographSource::Btf { .. } => None,
        }
    }

    /// What was found and done before the fit, for programs.
    pub(super) fn facts(&self) -> serde_json::Value {
        match &self.source {
            PhotographSource::Capture(set) => set.facts.clone().into(),
            PhotographSource::Btf { .. } => serde_json::json!({}),
        }
    }

    /// Photograph `i`, developed, or the part of it that was asked for.
    pub(super) fn photograph(&self, i: usize, job: &Job) -> Result<Raster> {
        match &self.source {
            PhotographSource::Capture(set) => set.photograph(i, job),
            PhotographSource::Btf { btf, chosen, crop } => {
                let photograph = btf.photograph(chosen[i], job)?;
                let cropped = crop.map(|part| photograph.crop(part.x, part.y, part.size));
                cropped.unwrap_or(Ok(photograph)).map_err(|e| e.at(&self.place))
            }
        }
    }
}

/// What is to be said of photographs that are missing: whether others are made in their place, which may be those of a test.
fn filled(absent: &str, fills: bool, holds_out: bool) -> String {
    match (fills, holds_out) {
        (false, _) => format!("{absent}: their values are interpolated from the others"),
        (true, false) => {
            format!("{absent}: they are interpolated from the others, and fitted as if they were photographs")
        }
        (true, true) => format!(
            "{absent}: they are interpolated from the others, also from those left out, and count as photographs"
        ),
    }
}

/// What is to be said of photographs that do not tell how the texture varies with the light, or with the view where there are to be
/// several.
fn constant(pairs: &[(String, Directions)], has_views: bool) -> Option<String> {
    let lights = distinct(pairs.iter().map(|(_, pair)| pair.light));
    let views = distinct(pairs.iter().map(|(_, pair)| pair.view));
    Some(match (pairs.len(), lights, views) {
        (1, ..) => {
            "there is one photograph: the texture is the same under all lights and from all views".to_owned()
        }
        (count, 1, _) => {
            format!("all {count} photographs have one light: the texture is the same under all lights")
        }
        (count, _, 1) if has_views => {
            format!("all {count} photographs have one view: the texture is the same from all views")
        }
        _ => return None,
    })
}

/// Refuses a file that is recognised by its name, under another one.
fn refuse_archive(path: &Path) -> Result<()> {
    if output::is_stream(path) {
        return Err(Error::usage(
            "photographs are many files, which standard input cannot be: name a file or folder",
        ));
    }
    let head = || -> Option<Vec<u8>> {
        let mut head = Vec::new();
        File::open(path).ok()?.take(16).read_to_end(&mut head).ok()?;
        Some(head)
    };
    // A pipe can be read only once.
    match path.is_file().then(head).flatten().and_then(|head| set_ending(&head)) {
        Some(ending) => Err(Error::usage(format!(
            "holds photographs under light and view, or an archive of them, which is known by its name: give it one that ends in \
             .{ending}"
        ))
        .at(path)),
        None => Ok(()),
    }
}

/// The number of distinct directions.
fn distinct(directions: impl Iterator<Item = Direction>) -> usize {
    let mut all: Vec<[u64; 3]> = directions.map(|direction| direction.to_array().map(f64::to_bits)).collect();
    all.sort_unstable();
    all.dedup();
    all.len()
}

/// Whether each photograph has one light for all texels.
fn has_one_light(basis: &Basis) -> bool {
    matches!(basis, Basis::Interpolated(_) | Basis::Learned(_))
}
