//! The sources of slopes.

use std::path::Path;

use relume::capture::{Capture, Photograph};
use relume::field::Basis;
use relume::format::MapRole;
use relume::surface::highlights::{self, HighlightOptions, Highlights, highlights};
use relume::surface::photometric_stereo::{StereoInput, photometric_stereo};
use relume::surface::shape_from_shading::{ShadingOptions, shape_from_shading};
use relume::surface::{self, STEEPEST, Slopes};
use relume::workflow::model_surface::SurfaceForm;
use relume::{Direction, Error, Picture, Planes, RasterSequence, Result, Size, Space};
use serde_json::{Value, json};

use super::compare::KnownShape;
use super::foresight::foresee;
use super::{Args, no_facts, refuse_strangers};
use crate::context::Context;
use crate::photographs::PhotographSet;
use crate::report::counted;
use crate::{input, normals, paths};

/// The slope of 50 degrees: for steeper normals of a polynomial only the azimuth is reliable.
const PTM_STEEPEST: f64 = 1.19;

/// The methods.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum HeightMethod {
    /// Photographs under many lights.
    PhotometricStereo,
    /// One photograph.
    ShapeFromShading,
    /// The directions of maximal luminance of a field.
    PtmNormals,
    /// A normal map.
    NormalMap,
}

impl HeightMethod {
    /// All methods.
    pub const ALL: [Self; 4] =
        [Self::PhotometricStereo, Self::ShapeFromShading, Self::PtmNormals, Self::NormalMap];

    /// The name in options and reports.
    pub const fn name(self) -> &'static str {
        match self {
            Self::PhotometricStereo => "photometric-stereo",
            Self::ShapeFromShading => "shape-from-shading",
            Self::PtmNormals => "ptm-normals",
            Self::NormalMap => "normal-map",
        }
    }
}

/// The result of a method.
#[derive(Debug)]
pub struct Shape {
    pub method: HeightMethod,
    /// How its normals were found, for people.
    pub how: String,
    pub slopes: Slopes,
    pub normals: Planes,
    pub albedo: Option<Picture>,
    /// Roughness and strength of highlights, if they were asked for.
    pub highlights: Option<Highlights>,
    /// The size of a texel in millimetres, where the photographs tell it.
    pub pixel_mm: Option<f64>,
    /// The texels that belong to the surface, if a mask says it.
    pub mask: Option<Vec<bool>>,
    /// For people, a line each.
    pub notes: Vec<String>,
    /// Reasons for doubt, a sentence each.
    pub warnings: Vec<String>,
    /// For programs.
    pub facts: Value,
}

impl Shape {
    fn of_normals(method: HeightMethod, normals: Planes, steepest_deg: Option<f64>) -> Result<Self> {
        let trusted = if method == HeightMethod::PtmNormals { PTM_STEEPEST } else { STEEPEST };
        let slopes =
            Slopes::from_normals(&normals, steepest_deg.map_or(trusted, |deg| deg.to_radians().tan()))?;
        Ok(Self {
            method,
            how: format!("by {}", method.name()),
            slopes,
            normals,
            albedo: None,
            highlights: None,
            pixel_mm: None,
            mask: None,
            notes: Vec::new(),
            warnings: Vec::new(),
            facts: no_facts(),
        })
    }

    /// Makes what lies outside the mask level, black, and rough.
    fn clear_outside(&mut self) {
        let Some(mask) = &self.mask else { return };
        let fill = |planes: &mut Planes, values: [f32; 3]| {
            for (plane, value) in planes.iter_mut().zip(values) {
                plane.iter_mut().zip(mask).filter(|(_, inside)| !**inside).for_each(|(v, _)| *v = value);
            }
        };
        fill(&mut self.normals, [0.0, 0.0, 1.0]);
        if let Some(albedo) = &mut self.albedo {
            fill(&mut albedo.planes, [0.0; 3]);
        }
        if let Some(highlights) = &mut self.highlights {
            fill(&mut highlights.roughness, [1.0; 3]);
            fill(&mut highlights.reflectance, [0.0; 3]);
        }
    }
}

/// Estimates the shape by the requested method, or by the one that suits the input.
pub fn find(args: &Args, known: &KnownShape, context: &Context) -> Result<Shape> {
    let is_capture = is_capture(&args.input);
    let method = args.method.unwrap_or_else(|| match MapRole::of_name(&args.input) {
        _ if is_capture => HeightMethod::PhotometricStereo,
        MapRole::Normal => HeightMethod::NormalMap,
        _ => HeightMethod::PtmNormals,
    });
    refuse_strangers(args, method, is_capture)?;
    let mut shape = by(method, args, known, is_capture, context)?;
    if let (Some(path), None) = (&args.mask, &shape.mask) {
        shape.mask = Some(input::mask(path, shape.slopes.size(), &context.job)?);
    }
    shape.clear_outside();
    Ok(shape)
}

/// The shape by a method.
fn by(
    method: HeightMethod,
    args: &Args,
    known: &KnownShape,
    is_capture: bool,
    context: &Context,
) -> Result<Shape> {
    match method {
        HeightMethod::PhotometricStereo => stereo(args, known, context),
        HeightMethod::ShapeFromShading => shading(args, known, is_capture, context),
        HeightMethod::PtmNormals => field_normals(args, known, context),
        HeightMethod::NormalMap => {
            let map = input::normals(&args.input, args.normal_maps.normal_y, &context.job)?;
            foresee(args, known, (map.normals.size(), 0, 0), context)?;
            let shape = Shape::of_normals(method, map.normals, args.steepest);
            let mut shape = shape.map_err(|e| e.at(&args.input))?;
            shape.notes.push(format!("read as {}", normals::described(map.y)));
            shape.facts = json!({ "normal_y": map.y });
            Ok(shape)
        }
    }
}

fn is_capture(path: &Path) -> bool {
    path.is_dir() || path.extension().is_some_and(|e| e.eq_ignore_ascii_case("lp"))
}

fn stereo(args: &Args, known: &KnownShape, context: &Context) -> Result<Shape> {
    let mut set = PhotographSet::open(&args.input, &args.photographs, args.mask.as_deref(), &context.job)?;
    args.refuse_photographs(&set.paths())?;
    let count = set.lights().len();
    if args.roughness_map.is_some() || args.specular_map.is_some() {
        highlights::check(count, set.lamps().is_some()).map_err(|e| e.at(&set.capture.light_file))?;
    }
    let fits = |size: Size, channels: usize| foresee(args, known, (size, channels, count), context);
    set.measure(&args.photographs, &fits, &context.job)?;
    let without_fall_off = set.with_fall_off();
    let load = |i: usize| {
        let developed = without_fall_off.apply(i, set.stored(i, &context.job)?);
        developed.map_err(|e| e.at(&set.capture.photographs[i].path))
    };
    let photographs = RasterSequence::open(&load)?;
    fits(photographs.size(), photographs.channels())?;
    let load = |i: usize| photographs.read(i);
    let options = args.stereo.options();
    let (lights, lamps) = (set.lights(), set.lamps());
    let input = StereoInput { lights, lamps: lamps.as_ref(), load: &load };
    let found =
        photometric_stereo(input, &options, &context.job).map_err(|e| e.at(&set.capture.light_file))?;
    let inside =
        set.mask().map_or(found.determined.len(), |mask| mask.iter().filter(|inside| **inside).count());
    let undetermined = lacking(&found.determined, set.mask());
    if undetermined == inside {
        return Err(Error::invalid("all photographs are black: there is nothing to find a shape of")
            .at(&set.capture.light_file));
    }
    let mut shape = Shape::of_normals(HeightMethod::PhotometricStereo, found.normals, args.steepest)?;
    shape.albedo = Some(found.albedo);
    if undetermined > 0 {
        shape.notes.push(format!(
            "{undetermined} texels are black under every light, or seem to face away, and were left level"
        ));
    }
    if args.roughness_map.is_some() || args.specular_map.is_some() {
        let found = highlights(input, &shape.normals, HighlightOptions::default(), &context.job)
            .map_err(|e| e.at(&set.capture.light_file))?;
        shape.notes.push(format!(
            "roughness of the whole {:.2}; {:.0} % of the texels show no highlight and have it",
            found.overall,
            100.0 * lacking(&found.seen, set.mask()) as f64 / inside as f64
        ));
        shape.highlights = Some(found);
    }
    shape.pixel_mm = lamps.as_ref().map(relume::lamps::LampPositions::mm_per_texel);
    shape.mask = set.mask().map(<[bool]>::to_vec);
    shape.warnings.clone_from(&set.warnings);
    shape.facts = json!({
        "lights": lights.len(),
        "options": options,
        "undetermined_texels": undetermined,
        "roughness": shape.highlights.as_ref().map(|seen| seen.overall),
        "texels_without_highlight": shape.highlights.as_ref().map(|found| lacking(&found.seen, set.mask())),
        "development": set.facts,
    });
    Ok(shape)
}

/// The texels of the surface of which something is false.
fn lacking(of_texels: &[bool], mask: Option<&[bool]>) -> usize {
    let is_inside = |texel: usize| mask.is_none_or(|mask| mask[texel]);
    of_texels.iter().enumerate().filter(|(texel, is)| !**is && is_inside(*texel)).count()
}

fn shading(args: &Args, known: &KnownShape, is_capture: bool, context: &Context) -> Result<Shape> {
    let photograph = photograph(args, is_capture)?;
    args.refuse_photographs(&[&photograph.path])?;
    let raster = input::raster(&photograph.path, &context.job)?;
    foresee(args, known, (raster.size(), 0, 0), context)?;
    let picture = raster.to_picture(Space::Linear);
    drop(raster);
    let options = ShadingOptions {
        albedo: args.shading.albedo,
        rounds: args.shading.rounds.unwrap_or(ShadingOptions::default().rounds),
        border: args.border,
        longest: args.shading.longest,
    };
    let luminance = surface::luminance(&picture.planes);
    let found = shape_from_shading(&luminance, photograph.light, &options, &context.job)
        .map_err(|e| e.at(&photograph.path))?;
    Ok(Shape {
        method: HeightMethod::ShapeFromShading,
        how: format!("by {}", HeightMethod::ShapeFromShading.name()),
        normals: found.slopes.normals(),
        slopes: found.slopes,
        albedo: None,
        highlights: None,
        pixel_mm: None,
        mask: None,
        warnings: Vec::new(),
        notes: vec![format!(
            "one photograph, {}: albedo {:.3}, shading off by {:.4} (root mean square)",
            photograph.path.display(),
            found.albedo,
            found.residual
        )],
        facts: json!({
            "photograph": paths::text(&photograph.path),
            "light": photograph.light.to_array(),
            "albedo": found.albedo,
            "rounds": options.rounds,
            "longest_texels": options.longest,
            "residual": found.residual,
        }),
    })
}

/// The photograph to read and its light.
fn photograph(args: &Args, is_capture: bool) -> Result<Photograph> {
    if !is_capture {
        let light = args.shading.light.ok_or_else(|| {
            Error::usage("shape from shading needs the light of the photograph: give --light X,Y,Z")
        })?;
        return Ok(Photograph { path: args.input.clone(), light, vector: light.to_array() });
    }
    let photographs =
        Capture::open_paired(&args.input, args.photographs.pair.unwrap_or_default())?.photographs;
    let off = |light: Direction| (light.z() - 0.5f64.sqrt()).abs();
    let chosen = match args.shading.photograph {
        Some(n) => photographs.get(n),
        None => photographs.iter().min_by(|a, b| off(a.light).total_cmp(&off(b.light))),
    };
    let chosen = chosen.cloned().ok_or_else(|| {
        Error::usage(format!("the capture has {}, counted from 0", counted(photographs.len(), "photograph")))
    })?;
    Ok(Photograph { light: args.shading.light.unwrap_or(chosen.light), ..chosen })
}

fn field_normals(args: &Args, known: &KnownShape, context: &Context) -> Result<Shape> {
    let job = &context.job;
    let opened = input::open(&args.input, job)?;
    let surface = match opened.parametric()? {
        Some(models) => SurfaceForm::of_models(&models, job)?,
        None => SurfaceForm::Functions(opened.into_field()?.field),
    };
    if matches!(&surface, SurfaceForm::Functions(field) if *field.basis() == Basis::Constant) {
        return Err(Error::usage(
            "is a picture without functions of light: name --method shape-from-shading with --light, or \
             --method normal-map",
        )
        .at(&args.input));
    }
    foresee(args, known, (surface.size(), surface.channels(), 0), context)?;
    let normals = surface.normals().map_err(|e| e.at(&args.input))?;
    let are_facets = matches!(surface, SurfaceForm::Facets { .. });
    let trusted = are_facets.then(|| STEEPEST.atan().to_degrees());
    let mut shape = Shape::of_normals(HeightMethod::PtmNormals, normals, args.steepest.or(trusted))?;
    match &surface {
        _ if are_facets => "from the normals of the fitted facets".clone_into(&mut shape.how),
        SurfaceForm::Functions(field) if *field.basis() != Basis::Ptm => {
            "from the directions in which its functions are brightest".clone_into(&mut shape.how);
        }
        _ => {}
    }
    shape.albedo = Some(surface.albedo());
    Ok(shape)
}
