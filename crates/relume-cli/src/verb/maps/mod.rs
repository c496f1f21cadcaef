//! `relume maps`: the maps of a material under the names and in the packings of other programs.

mod known;

use std::path::{Path, PathBuf};

use relume::capture::dome::ReliefBorder;
use relume::field::{Basis, TexelModel};
use relume::format::ktx2::TextureFormat;
use relume::format::share::planes::PlaneDepth;
use relume::format::share::{ShareExtras, ShareFiles};
use relume::format::{FieldFile, read_mesh};
use relume::render::Primitive;
use relume::workflow::map_export::{
    ExportOptions, MapPreset, MaterialMaps, PreviewObject, encode_preview, export_maps,
};
use relume::workflow::tiling::MeasuredTiling;
use relume::workflow::{Btf, Missing};
use relume::{Error, Job, Named, Result};
use serde_json::{Value, json};

use known::KnownMaps;

use crate::context::Context;
use crate::output::Folder;
use crate::report::{Report, counted};
use crate::verb::capture::maps::Reading;
use crate::{args, input, normals};

/// Arguments of `relume maps`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  relume maps wall -o unreal --preset unreal --name Wall --tile\n  \
                        relume maps wool.zip -o wool_maps --preset polyhaven\n  \
                        relume maps coin.ptm -o coin_maps --preset gltf --preview plane\n  \
                        relume maps wall -o scene --preset blender --materialx --usd")]
pub struct Args {
    /// A folder of maps known by the words in their names (at least colour, and height or normals), a texture of functions, or one of light
    /// and view (folder, .zip, .btf), whose base colour, normals, roughness and specular reflectance are fitted
    input: PathBuf,
    /// The folder to write
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Whose names, packings, bit depths and direction of normals
    #[arg(long, value_parser = args::named::<MapPreset>())]
    preset: MapPreset,
    /// The name of the material in file names
    #[arg(long, default_value = "Material")]
    name: String,
    /// The material tiles: occlusion and heights wrap around, and every map is checked to tile
    #[arg(long)]
    tile: bool,
    /// Size of a texel in millimetres: heights are then recorded in millimetres [default: as the heights record it]
    #[arg(long, value_name = "MM", value_parser = args::texel_mm)]
    texel_mm: Option<f64>,
    /// Texels from the lowest to the highest code of a height map without a record [default: a 25th of the width]
    #[arg(long, value_name = "TEXELS")]
    height_scale: Option<f64>,
    /// How colours, normals and data are stored: png, or ktx2 with all levels of detail, uncompressed or in blocks of BC7
    /// (bc7). Heights are PNG or EXR in any case
    #[arg(long, default_value = "png", value_parser = args::named::<TextureFormat>())]
    textures: TextureFormat,
    /// Also write NAME.glb, which any viewer of glTF shows: the material on a sphere, plane, torus or cloth, or on a mesh (.obj,
    /// .glb); with the functions of a texture in the extension RELUME_reflectance
    #[arg(long, value_name = "OBJECT")]
    preview: Option<PathBuf>,
    /// Also write NAME.mtlx, a MaterialX document of an OpenPBR surface
    #[arg(long)]
    materialx: bool,
    /// Also write NAME.usda, a USD layer of a preview surface
    #[arg(long)]
    usd: bool,
    #[command(flatten)]
    normal_maps: normals::ReadArgs,
}

impl Args {
    fn options(&self) -> Result<ExportOptions> {
        let options = ExportOptions {
            preset: self.preset,
            name: self.name.clone(),
            mm_per_texel: self.texel_mm,
            textures: self.textures,
            materialx: self.materialx,
            usd: self.usd,
        };
        options.validate()?;
        Ok(options)
    }

    /// The maps.
    fn maps(&self, job: &Job) -> Result<MapSource> {
        let border = if self.tile { ReliefBorder::Wrap } else { ReliefBorder::Clamp };
        if Btf::is_at(&self.input) {
            let btf = Btf::open(&self.input, Missing::Fill, job)?;
            if let Some(absent) = btf.list().absent() {
                job.about(&self.input).remark(format!("{absent}: the maps are fitted to the others"));
            }
            return Ok(MapSource::of(MaterialMaps::of_btf(&btf, border, job)?));
        }
        if self.input.is_dir() && !relume::format::web::is_at(&self.input) {
            let (height_scale, normal_y) = (self.height_scale, self.normal_maps.normal_y);
            let written = |size| self.options().map(|options| options.footprint(size).peak);
            let foresee = |size| job.check_bytes("writing the maps", written(size)?);
            let reading = Reading { height_scale, normal_y, border: Some(border) };
            let KnownMaps { maps, mm_per_texel, has_heights, mut said } =
                known::read(&self.input, &reading, &foresee, job)?;
            if height_scale.is_some() && !has_heights {
                said.push("--height-scale is about a height map, and there is none".to_owned());
            }
            return Ok(MapSource { said, mm_per_texel, has_heights, ..MapSource::of(maps) });
        }
        let of_maps = [
            ("--height-scale", self.height_scale.is_some()),
            ("--normal-y", self.normal_maps.normal_y.is_some()),
        ];
        if let Some((option, _)) = of_maps.iter().find(|(_, given)| *given) {
            return Err(Error::usage(format!(
                "{option} is about the maps of a folder, and this is a texture"
            ))
            .at(&self.input));
        }
        self.of_texture(border, job).map_err(|e| e.at(&self.input))
    }

    /// The maps of reflectance models as they are, or those derived from functions.
    fn of_texture(&self, border: ReliefBorder, job: &Job) -> Result<MapSource> {
        let opened = input::open(&self.input, job)?;
        match opened.parametric()? {
            Some(models) => {
                let maps = MaterialMaps::of_models(&models, border, job)?;
                let shows_functions = self.preview.is_some() && *models.model() != TexelModel::Ggx;
                let functions = shows_functions.then(|| opened.into_field()).transpose()?;
                Ok(MapSource { functions, ..MapSource::of(maps) })
            }
            None => {
                let file = opened.into_field()?;
                if file.record.heights.is_some() || file.record.normal_y.is_some() {
                    return Err(Error::usage(
                        "this is a map of heights or normals and not of colours: name the folder that holds all maps",
                    ));
                }
                let maps = MaterialMaps::of_field(&file.field, border, job)?;
                let is_picture = *file.field.basis() == Basis::Constant;
                let said = is_picture.then(|| {
                    "a picture says nothing of normals, heights and gloss: those of a level matt surface are written".to_owned()
                });
                Ok(MapSource { functions: Some(file), said: Vec::from_iter(said), ..MapSource::of(maps) })
            }
        }
    }
}

/// The maps, and where they come from.
struct MapSource {
    maps: MaterialMaps,
    /// The texture of functions that a preview shows, if any.
    functions: Option<FieldFile>,
    /// The side of a texel, where the files have it.
    mm_per_texel: Option<f64>,
    /// Whether there is a map of heights.
    has_heights: bool,
    /// What the report says of the files.
    said: Vec<String>,
}

impl MapSource {
    fn of(maps: MaterialMaps) -> Self {
        Self { maps, functions: None, mm_per_texel: None, has_heights: false, said: Vec::new() }
    }
}

/// Reads or derives the maps, and writes them.
pub fn run(args: &Args, context: &Context) -> Result<Report> {
    let (job, mut options) = (&context.job, args.options()?);
    let folder = Folder::stage(&args.output, &[&args.input], context)?;
    let MapSource { maps, functions: file, mm_per_texel, has_heights, said: of_files } = args.maps(job)?;
    options.mm_per_texel = options.mm_per_texel.or(mm_per_texel);
    let tiling = args.tile.then(|| tiling(&maps));
    let mut store = |name: &str, bytes: &[u8]| folder.add(name, bytes);
    let written = export_maps(&maps, &options, job, &mut store)?;
    let lacks_heights = has_heights && !options.preset.has_heights();
    let of_heights = lacks_heights
        .then(|| format!("the preset {} has no map of heights: they were left out", options.preset.name()));
    let mut more: Vec<String> = Vec::new();
    if let Some(object) = &args.preview {
        let name = format!("{}.glb", args.name);
        store(&name, &preview(args, object, &maps, file.as_ref(), job)?)?;
        more.push(name);
    }
    let documents = [(args.materialx, "mtlx"), (args.usd, "usda")];
    more.extend(documents.iter().filter(|(wanted, _)| *wanted).map(|(_, e)| format!("{}.{e}", args.name)));
    let json = json!({
        "preset": args.preset,
        "name": args.name,
        "maps": written,
        "documents": more,
        "tiling": tiling,
    });
    folder.add("maps.json", format!("{json:#}\n").as_bytes())?;
    let outputs = folder.commit()?;
    let list =
        written.iter().map(|map| format!("  {}: {}, {} bits", map.file, map.channels.join(", "), map.bits));
    let list: Vec<String> = list.chain(more.iter().map(|name| format!("  {name}"))).collect();
    let warnings = shown(&tiling);
    let said = match (&tiling, warnings.is_empty()) {
        (Some(_), true) => "; every map tiles",
        _ => "",
    };
    let maps = counted(written.len(), "map");
    let text = format!("{}: {maps}{said}\n{}", args.output.display(), list.join("\n"));
    Ok(Report::new(text, json)
        .with_outputs(outputs)
        .with_warnings(warnings)
        .with_warnings(of_files)
        .with_warnings(of_heights))
}

/// The preview on a built-in object or a mesh.
fn preview(
    args: &Args,
    object: &Path,
    maps: &MaterialMaps,
    file: Option<&FieldFile>,
    job: &Job,
) -> Result<Vec<u8>> {
    let size = maps.size();
    let primitive = object.to_str().and_then(Primitive::from_name);
    let mesh = match primitive {
        Some(primitive) => primitive.mesh_with_aspect(size.width as f64 / size.height as f64),
        None => read_mesh(object, job)?,
    };
    let extras =
        ShareExtras { title: args.name.clone(), mm_per_texel: args.texel_mm, ..ShareExtras::default() };
    let share = file.map(|file| ShareFiles::new(file, &extras, PlaneDepth::Kept, job)).transpose()?;
    let tiling = primitive.map_or([1.0; 2], Primitive::default_tiling);
    let shown = PreviewObject { mesh: &mesh, tiling, functions: share.as_ref() };
    encode_preview(maps, &args.name, &shown, job).map_err(|e: Error| e.at(object))
}

/// How well each map tiles.
fn tiling(maps: &MaterialMaps) -> Vec<Value> {
    let of = |(name, planes): (&'static str, &relume::Planes)| {
        let measured = MeasuredTiling::of_texture(planes);
        json!({ "map": name, "wrap": measured.wrap, "shows": measured.shows })
    };
    maps.planes().into_iter().map(of).collect()
}

/// A warning for each map whose border may show.
fn shown(tiling: &Option<Vec<Value>>) -> Vec<String> {
    let shows = tiling.iter().flatten().filter(|map| map["shows"] == true);
    shows
        .map(|map| {
            format!("the {} map does not tile: its border may show", map["map"].as_str().unwrap_or(""))
        })
        .collect()
}
