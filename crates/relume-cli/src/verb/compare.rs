//! `relume compare`: the distance between two textures, texel by texel or statistically.

use std::f64::consts::FRAC_PI_4;
use std::fmt::Write;
use std::path::{Path, PathBuf};

use relume::field::Basis;
use relume::format::Content;
use relume::format::npy::Array;
use relume::metric::texture::{
    Distances, SlicedOptions, Source, Sources, copying::Copying, copying::copying, distances, seams::Seams,
    seams::seams, wrap::Wrap, wrap::wrap,
};
use relume::metric::{psnr, rmse};
use relume::render::{Sweep, relight};
use relume::{Direction, Error, Planes, ReflectanceField, Result, Size, Space};
use serde_json::json;

use crate::context::Context;
use crate::report::Report;
use crate::{evaluated, input, output};

/// Arguments of `relume compare`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  relume compare photograph.png relit.png\n  relume synth wool.ptm -o cloth.ptm --size 512 \
                  --source-map map.npy\n  relume compare --texture wool.ptm cloth.ptm --source-map map.npy\n\n\
                  All values are compared sRGB-encoded. Textures of functions are compared as pictures under \
                  several lights: the mean and the worst of them are given. docs/measures.md says what each measure \
                  can and cannot see."
)]
pub struct Args {
    /// The reference: a .ptm, an .exr field, a picture or a .rlm model; - is standard input
    reference: PathBuf,
    /// The texture to compare with it; of the same size unless --texture is given
    other: PathBuf,
    /// Compare the statistics of the textures, of any sizes, instead of texel by texel
    #[arg(long)]
    texture: bool,
    /// Number of lights under which functions are compared: one at the zenith, the others in a circle 45
    /// degrees from it
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u16).range(1..=1000))]
    lights: u16,
    /// The source map of the second texture in the first (.npy or .exr of `relume synth --source-map`):
    /// measures cuts and copying
    #[arg(long, value_name = "FILE", requires = "texture")]
    source_map: Option<PathBuf>,
    /// Seed of the patches drawn for the patch distance
    #[arg(long, value_name = "N", default_value_t = 0, requires = "texture")]
    seed: u64,
    #[command(flatten)]
    evaluated: evaluated::Args,
}

/// Compares and reports.
pub fn run(args: &Args, context: &Context) -> Result<Report> {
    let inputs = [Some(&args.reference), Some(&args.other), args.source_map.as_ref()];
    if inputs.into_iter().flatten().filter(|path| output::is_stream(path)).count() > 1 {
        return Err(Error::usage("standard input can be read only once: give - for one input at most"));
    }
    let read = |path: &Path| args.evaluated.texture_of(path, &context.job);
    let (reference, other) = (read(&args.reference)?, read(&args.other)?);
    args.evaluated.check(reference.of_model || other.of_model)?;
    let pair = Pair { reference: reference.field, other: other.field };
    let lights = pair.lights(args.lights);
    if !args.texture {
        return texel_by_texel(&pair, &lights, args);
    }
    let map = args.source_map.as_deref().map(|path| SourceFile::read(path, context)).transpose()?;
    let measured = Measured::of(&pair, &lights, map.as_ref(), args, context)?;
    Ok(Report::new(measured.text(args), measured.json(&lights)))
}

/// The two textures.
struct Pair {
    reference: ReflectanceField,
    other: ReflectanceField,
}

impl Pair {
    /// The lights to compare under: one is enough for two pictures.
    fn lights(&self, count: u16) -> Vec<Direction> {
        if [&self.reference, &self.other].iter().all(|field| *field.basis() == Basis::Constant) {
            return vec![Direction::ZENITH];
        }
        let ring = Sweep::Orbit { lights: usize::from(count) - 1, polar_rad: FRAC_PI_4 };
        [Direction::ZENITH].into_iter().chain(ring.directions()).collect()
    }

    /// Both under one light, sRGB-encoded.
    fn under(&self, light: Direction) -> [Planes; 2] {
        [&self.reference, &self.other].map(|field| relight(field, light).to_space(Space::Srgb).planes)
    }
}

fn texel_by_texel(pair: &Pair, lights: &[Direction], args: &Args) -> Result<Report> {
    let sizes = [pair.reference.size(), pair.other.size()];
    if sizes[0] != sizes[1] {
        return Err(Error::usage(format!(
            "is {} texels and the reference {}: give --texture to compare textures of different sizes",
            sizes[1], sizes[0]
        ))
        .at(&args.other));
    }
    let error = |light: &Direction| {
        let [a, b] = pair.under(*light);
        Ok((psnr(&a, &b)?, rmse(&a, &b)?))
    };
    let errors = lights.iter().map(error).collect::<Result<Vec<(f64, f64)>>>()?;
    let count = errors.len() as f64;
    let psnr_db = errors.iter().map(|e| e.0).sum::<f64>() / count;
    let rmse = errors.iter().map(|e| e.1).sum::<f64>() / count;
    let worst = errors.iter().copied().fold((f64::INFINITY, 0.0f64), |w, e| (w.0.min(e.0), w.1.max(e.1)));
    let mut text = format!("PSNR {psnr_db:.2} dB, RMSE {rmse:.5} of white");
    if lights.len() > 1 {
        let _ =
            write!(text, " (means over {} lights; worst {:.2} dB, {:.5})", lights.len(), worst.0, worst.1);
    }
    // JSON has no infinity: equal textures have no PSNR.
    let finite = |db: f64| db.is_finite().then_some(db);
    let json = json!({
        "psnr_db": finite(psnr_db),
        "rmse": rmse,
        "worst": { "psnr_db": finite(worst.0), "rmse": worst.1 },
        "lights": directions(lights),
    });
    Ok(Report::new(text, json))
}

fn directions(lights: &[Direction]) -> Vec<[f64; 3]> {
    lights.iter().map(|light| light.to_array()).collect()
}

/// All measures of --texture; of several lights the worst seam.
struct Measured {
    distances: Vec<Distances>,
    wraps: [Wrap; 2],
    seams: Option<Seams>,
    copying: Option<Copying>,
}

impl Measured {
    fn of(
        pair: &Pair,
        lights: &[Direction],
        map: Option<&SourceFile>,
        args: &Args,
        context: &Context,
    ) -> Result<Self> {
        let exemplars = [pair.reference.size()];
        let sources = map
            .map(|map| Sources::new(map.size, &map.texels, &exemplars))
            .transpose()
            .map_err(|e| e.at(args.source_map.as_deref().unwrap_or(Path::new("-"))))?;
        let options = SlicedOptions { seed: args.seed, ..SlicedOptions::default() };
        let mut found = Self {
            distances: Vec::new(),
            wraps: [Wrap { ratio: 0.0, rank: 0.0 }; 2],
            seams: None,
            copying: sources.as_ref().map(copying),
        };
        context.job.start("comparing", lights.len() as u64);
        for &light in lights {
            for field in [&pair.reference, &pair.other] {
                context.job.check(
                    "the texture under a light",
                    field.size(),
                    8 * field.layout().channels() as u64,
                )?;
            }
            let [a, b] = pair.under(light);
            found.distances.push(distances(&a, &b, &options, &context.job)?);
            for (worst, wrap) in found.wraps.iter_mut().zip(wrap(&b)) {
                *worst = if wrap.ratio > worst.ratio { wrap } else { *worst };
            }
            if let Some(sources) = &sources {
                let seams = seams(&b, sources)?;
                found.seams = found.seams.filter(|worst| worst.ratio >= seams.ratio).or(Some(seams));
            }
            context.job.advance(1)?;
        }
        Ok(found)
    }

    fn json(&self, lights: &[Direction]) -> serde_json::Value {
        json!({
            "mean": Distances::mean(&self.distances),
            "worst": Distances::worst(&self.distances),
            "by_light": self.distances,
            "wrap": { "right_to_left": self.wraps[0], "bottom_to_top": self.wraps[1] },
            "seams": self.seams,
            "copying": self.copying,
            "lights": directions(lights),
        })
    }

    fn text(&self, args: &Args) -> String {
        let (Some(mean), Some(worst)) = (Distances::mean(&self.distances), Distances::worst(&self.distances))
        else {
            return String::new();
        };
        let mut text = format!(
            "{} against {}, over {} light{}\n{:<34} {:>8} {:>8}\n",
            args.other.display(),
            args.reference.display(),
            self.distances.len(),
            if self.distances.len() == 1 { "" } else { "s" },
            "",
            "mean",
            "worst"
        );
        let rows = [
            ("patches at several scales", mean.sliced, worst.sliced),
            ("histogram", mean.histogram, worst.histogram),
            ("autocorrelation", mean.autocorrelation, worst.autocorrelation),
            ("spectrum, dB", mean.spectrum_db, worst.spectrum_db),
            ("steerable pyramid, 1 - STSIM-2", mean.steerable, worst.steerable),
        ];
        for (name, mean, worst) in rows {
            let _ = writeln!(text, "{name:<34} {mean:>8.4} {worst:>8.4}");
        }
        let [x, y] = self.wraps;
        let _ = write!(
            text,
            "wrap: step over the border {:.2} (right to left) and {:.2} (bottom to top) times that inside",
            x.ratio, y.ratio
        );
        self.append_sources(&mut text);
        text
    }

    fn append_sources(&self, text: &mut String) {
        if let Some(seams) = self.seams {
            let _ = write!(
                text,
                "\ncuts: {:.1} % of neighbours, step {:.2} times that inside",
                100.0 * seams.share,
                seams.ratio
            );
        }
        if let Some(copying) = self.copying {
            let _ = write!(
                text,
                "\ncopying: {:.1} % of the exemplar used, evenness {:.3}, a texel at most {} times; pieces of {:.1} \
                 texels, the largest {}, the longest run {}",
                100.0 * copying.coverage,
                copying.evenness,
                copying.most_used,
                copying.mean_piece,
                copying.largest_piece,
                copying.longest_run
            );
        }
    }
}

/// A source map as `relume synth` writes it.
struct SourceFile {
    size: Size,
    texels: Vec<Source>,
}

impl SourceFile {
    fn read(path: &Path, context: &Context) -> Result<Self> {
        let opened = input::open(path, &context.job)?;
        let read = match opened.content() {
            Content::Array => Self::of_array(&opened.into_array()?),
            _ => opened.into_labelled().and_then(|(names, planes)| Self::of_planes(&names, &planes)),
        };
        read.map_err(|e| e.at(path))
    }

    fn of_array(array: &Array) -> Result<Self> {
        if array.components != 3 {
            return Err(Error::invalid(format!(
                "the array has {} numbers a texel: expected x, y and exemplar",
                array.components
            )));
        }
        let (values, _) = array.values.as_chunks::<3>();
        let texels = values.iter().map(|v| source(v.map(f64::from))).collect::<Result<_>>()?;
        Ok(Self { size: array.size, texels })
    }

    fn of_planes(names: &[String], planes: &Planes) -> Result<Self> {
        let place = |name: &str| {
            let missing =
                || Error::invalid(format!("the picture has no channel '{name}': expected x, y and exemplar"));
            names.iter().position(|n| n == name).ok_or_else(missing)
        };
        let channels = [place("x")?, place("y")?, place("exemplar")?];
        let texel = |i: usize| source(channels.map(|k| f64::from(planes.plane(k)[i])));
        let texels = (0..planes.size().texels()).map(texel).collect::<Result<_>>()?;
        Ok(Self { size: planes.size(), texels })
    }
}

fn source(numbers: [f64; 3]) -> Result<Source> {
    if numbers.iter().any(|v| v.fract() != 0.0 || !(0.0..f64::from(u32::MAX)).contains(v)) {
        return Err(Error::invalid(format!(
            "{numbers:?} is not a position in an exemplar: expected whole numbers from 0"
        )));
    }
    let [x, y, exemplar] = numbers.map(|v| v as u32);
    Ok(Source { exemplar, x, y })
}
