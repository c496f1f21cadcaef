//! Photographs of a capture as the verbs read them: located, checked, and developed as the options ask.

mod intensities;
mod measure;
mod options;
mod test;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use relume::capture::develop::{
    Development, InputSpace, ReadingCheck, TurnedFrames, check_reading, even_field, linear, sample_texels,
};
use relume::capture::{Capture, pictures_in};
use relume::lamps::LampPositions;
use relume::words::listed;
use relume::{Direction, Error, Job, Planes, Raster, Result, Samples, Space};
use serde_json::{Map, Value, json};

pub use options::PhotographArgs;

use crate::input;
use crate::output::CaptureFiles;
use crate::report::counted;
use intensities::intensities;

/// The most photographs that a warning names, and what stands between them.
const LISTED: usize = 6;
const BETWEEN: &str = "; ";

/// The photographs of a capture, developed when they are read.
pub struct PhotographSet {
    pub capture: Capture,
    files: CaptureFiles,
    turned: TurnedFrames,
    /// The photograph read first and its recorded orientation.
    first_turn: OnceLock<(usize, u16)>,
    development: Development,
    lights: Vec<(String, Direction)>,
    /// For people, a sentence each.
    pub warnings: Vec<String>,
    /// For programs: what was found and done.
    pub facts: Map<String, Value>,
    /// The numbers of photographs that were saturated over half of the surface when they were read, where their values change.
    white: Mutex<BTreeSet<usize>>,
}

impl PhotographSet {
    /// Locates the photographs and prepares their development; `mask` names a picture of the texels that belong to the surface:
    /// others are black in developed photographs. What the photographs themselves tell is found by
    /// [`PhotographSet::measure`].
    ///
    /// # Errors
    /// Everything wrong with the capture or a file that an option names, and a mask of another size or one that leaves nothing.
    pub fn open(path: &Path, args: &PhotographArgs, mask: Option<&Path>, job: &Job) -> Result<Self> {
        let capture = Capture::open_paired(path, args.pair.unwrap_or_default())?;
        let files = CaptureFiles::of(&capture)?;
        let (lights, warnings) = (capture.lights(), capture.warnings.clone());
        let development = Development {
            crop: args.crop,
            reduction: args.reduce.unwrap_or(1) as usize,
            ..Development::default()
        };
        let mut set = Self {
            capture,
            files,
            turned: args.orientation.unwrap_or_default(),
            first_turn: OnceLock::new(),
            development,
            lights,
            warnings,
            facts: Map::new(),
            white: Mutex::default(),
        };
        set.read_files(args, job)?;
        set.doubt_ambient(job)?;
        set.place_lamps(args, job)?;
        set.choose_space(args, job)?;
        set.development.mask = mask.map(|path| set.mask_of_texels(path, job)).transpose()?;
        Ok(set)
    }

    /// The texels that a mask leaves of developed photographs: its size is that of the photographs, or what `--crop` and
    /// `--reduce` leave of it.
    fn mask_of_texels(&self, path: &Path, job: &Job) -> Result<Vec<bool>> {
        let mask = input::open(path, job)?.into_mask()?;
        let whole = self.stored(0, job)?.size();
        self.development.mask_of_texels(&mask.painted, mask.size, whole).map_err(|e| e.at(path))
    }

    /// The texels that the mask leaves, if there is one.
    pub fn mask(&self) -> Option<&[bool]> {
        self.development.mask.as_deref()
    }

    /// The name and light of each photograph.
    pub fn lights(&self) -> &[(String, Direction)] {
        &self.lights
    }

    /// The paths of the photographs.
    pub fn paths(&self) -> Vec<&Path> {
        self.capture.photographs.iter().map(|p| p.path.as_path()).collect()
    }

    /// The lamps over the texels, where their places are known.
    pub fn lamps(&self) -> Option<LampPositions> {
        self.development.lamps_over_texels()
    }

    /// Photograph `i`, developed.
    ///
    /// # Errors
    /// As the reader and [`Development::apply`]; the error names the file.
    pub fn photograph(&self, i: usize, job: &Job) -> Result<Raster> {
        let stored = self.stored(i, job)?;
        // Developed samples do not tell.
        if self.development.changes_values() && 2 * stored.samples().saturated() >= stored.samples().len() {
            self.white.lock().unwrap_or_else(PoisonError::into_inner).insert(i);
        }
        let developed = self.development.apply(i, stored);
        developed.map_err(|e| e.at(&self.capture.photographs[i].path))
    }

    /// What is to be said of saturated photographs among those read so far, where development hides them.
    pub fn saturation(&self) -> Option<String> {
        let white = self.white.lock().unwrap_or_else(PoisonError::into_inner);
        let names: Vec<&str> = white.iter().map(|&i| self.lights[i].0.as_str()).collect();
        (!white.is_empty()).then(|| {
            format!(
                "{} of {} photographs are saturated over half of what they show, where no texture can be fitted, whatever is undone in \
                 them: expose them shorter ({})",
                white.len(),
                self.lights.len(),
                listed(&names, LISTED, BETWEEN)
            )
        })
    }

    /// As [`PhotographSet::photograph`], but with the fall-off of near lamps left in, which photometric stereo takes into
    /// account itself.
    pub fn with_fall_off(&self) -> Development {
        Development { lamps: None, ..self.development.clone() }
    }

    /// Photograph `i` before its development.
    ///
    /// # Errors
    /// Those of the reader, and photographs turned unlike the first.
    pub fn stored(&self, i: usize, job: &Job) -> Result<Raster> {
        let path = &self.capture.photographs[i].path;
        let opened = self.files.open(path, job)?;
        if self.turned == TurnedFrames::Ignore {
            return opened.into_unturned_raster();
        }
        let orientation = opened.orientation();
        let (first, usual) = *self.first_turn.get_or_init(|| (i, orientation));
        if orientation != usual && self.turned == TurnedFrames::Alike {
            return Err(Error::invalid(format!(
                "the camera recorded orientation {orientation} in it and {usual} in {}: a camera that looks down turns \
                 photographs by chance; give --orientation ignore to take them as stored, or apply to turn each",
                self.lights[first].0
            ))
            .at(path));
        }
        opened.into_raster()
    }

    /// Reads what the options name.
    fn read_files(&mut self, args: &PhotographArgs, job: &Job) -> Result<()> {
        // Declared before the other photographs are read: theirs are of the same space.
        self.development.space = match args.input_space {
            Some(InputSpace::Linear) => Some(Space::Linear),
            _ => None,
        };
        if let Some(path) = &args.intensities {
            self.development.intensities = intensities(path, self.lights.len())?;
            self.facts.insert("intensities".to_owned(), json!(self.development.intensities));
        }
        let of = |path: &Path, space| Ok::<_, Error>(linear(&input::raster(path, job)?, space));
        if let Some(path) = &args.ambient_frame {
            self.development.ambient = Some(of(path, self.development.space)?);
        }
        if let Some(path) = &args.white_card {
            let cards = if path.is_dir() { pictures_in(path)? } else { vec![path.clone()] };
            if cards.len() != 1 && cards.len() != self.lights.len() {
                return Err(Error::invalid(format!(
                    "holds {} of a white card for {}: expected one, or one for each",
                    counted(cards.len(), "photograph"),
                    counted(self.lights.len(), "light")
                ))
                .at(path));
            }
            let field = |card: &PathBuf| {
                even_field(of(card, self.development.space)?).map(Arc::new).map_err(|e| e.at(card))
            };
            self.development.flat = cards.iter().map(field).collect::<Result<_>>()?;
        }
        Ok(())
    }

    /// Says where the photograph without the lamp is about as bright as the first one with it.
    fn doubt_ambient(&mut self, job: &Job) -> Result<()> {
        const NEARLY: f64 = 0.9;
        let Some(ambient) = &self.development.ambient else { return Ok(()) };
        let sum = |planes: &Planes| {
            planes.as_slice().iter().map(|v| f64::from(*v)).sum::<f64>() / planes.as_slice().len() as f64
        };
        let first = linear(&self.stored(0, job)?, self.development.space);
        if sum(ambient) > NEARLY * sum(&first) {
            self.warnings.push(format!(
                "the photograph of the ambient light is about as bright as {}, of which it is taken away: was it made without the lamp?",
                self.lights[0].0
            ));
        }
        Ok(())
    }

    /// The places of near lamps, and with them the directions from the middle of the surface.
    fn place_lamps(&mut self, args: &PhotographArgs, job: &Job) -> Result<()> {
        let Some(surface_mm) = args.surface_mm else { return Ok(()) };
        let whole = self.stored(0, job)?.size();
        let place = |p: &relume::capture::Photograph| match args.lamp_mm {
            Some(mm) => p.light.to_array().map(|c| c * mm),
            None => p.vector,
        };
        let positions: Vec<[f64; 3]> = self.capture.photographs.iter().map(place).collect();
        let is_unit = |p: &[f64; 3]| (0.5..2.0).contains(&p.iter().map(|c| c * c).sum::<f64>().sqrt());
        if args.lamp_mm.is_none() && positions.iter().all(is_unit) {
            return Err(Error::usage(
                "--surface-mm needs positions in millimetres, and the light file has directions: give also --lamp-mm, the \
                 distance of the lamps",
            )
            .at(&self.capture.light_file));
        }
        if args.lamp_mm.is_some() && !self.capture.photographs.iter().all(|p| is_unit(&p.vector)) {
            self.warnings.push(
                "the light file has positions, and --lamp-mm puts their lamps at another distance: leave it out to take the \
                 positions"
                    .to_owned(),
            );
        }
        let lamps = LampPositions::new(positions, (whole.width, whole.height), surface_mm)
            .map_err(|e| e.at(&self.capture.light_file))?;
        for (i, (_, light)) in self.lights.iter_mut().enumerate() {
            *light = lamps.direction(i);
        }
        self.development.lamps = Some(lamps);
        Ok(())
    }

    /// Compares both readings of integer samples and takes the one asked for, or the better one.
    fn choose_space(&mut self, args: &PhotographArgs, job: &Job) -> Result<()> {
        let Some(asked) = args.input_space else { return Ok(()) };
        let check = self.check_reading(job)?;
        let taken = match (asked, check) {
            (InputSpace::Linear, _) => Space::Linear,
            (InputSpace::Srgb, _) | (InputSpace::Auto, None) => Space::Srgb,
            (InputSpace::Auto, Some(check)) => check.better(),
        };
        let is_float = matches!(self.stored(0, job)?.samples(), Samples::F32(_));
        if !is_float {
            self.development.space = (taken == Space::Linear).then_some(Space::Linear);
            self.warnings.extend(check.and_then(|check| check.warning(taken)));
        }
        if asked == InputSpace::Auto && check.is_none_or(|check| !check.is_clear()) && !is_float {
            self.warnings.push(format!(
                "the photographs do not tell whether they are linear: read as {taken}; declare it with --input-space"
            ));
        }
        self.facts.insert("input_space".to_owned(), json!(taken));
        self.facts.insert("reading_check".to_owned(), json!(check));
        Ok(())
    }

    /// How well a matt surface explains the photographs, read both ways.
    pub fn check_reading(&self, job: &Job) -> Result<Option<ReadingCheck>> {
        let load = |i: usize| self.stored(i, job);
        Ok(check_reading(&sample_texels(&self.lights, &load, None, job)?))
    }
}
