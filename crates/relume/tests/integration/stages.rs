//! The library's stages as functions of a job, on inputs of our own: what is promised of all of them
//! (the memory they foresee, how soon they stop) is tested over this list.

use std::sync::Arc;

use relume::analysis::analyze;
use relume::capture::dome::sampling::{all_pairs, random_pairs};
use relume::capture::dome::{Dome, DomeOptions, Gonioreflectometer, lights};
use relume::direction::Directions;
use relume::field::{Basis, Domain, IndexSpace, Metric, PlaneLayout};
use relume::fit::{FitOptions, fit};
use relume::format::animation::{encode_apng_with, encode_gif_with};
use relume::format::bonn::{
    BonnBtf, BtfColorModel, BtfFactors, BtfScalar, FactorShape, encode_dfmf, encode_fmf,
};
use relume::format::{
    Depth, ExrDepth, FieldFormat, HeightFormat, PictureFormat, decode_field, encode_field, encode_height_with,
};
use relume::metric::texture::{SlicedOptions, sliced, spectrum, steerable};
use relume::numeric::random::{Purpose, Stream};
use relume::procedural::{Material, MaterialOptions};
use relume::random_field::{ModelOptions, RealisationOptions, model_field};
use relume::render::{Mesh, MeshRelief, Primitive, RenderOptions, render, render_relief};
use relume::surface::integrate::{IntegrateOptions, integrate};
use relume::surface::photometric_stereo::{StereoInput, StereoOptions, photometric_stereo};
use relume::surface::shape_from_shading::{ShadingOptions, shape_from_shading};
use relume::surface::{STEEPEST, Slopes};
use relume::synthesis::fill::{FillMethod, FillOptions, fill, tileable};
use relume::synthesis::noise::{Noise, NoiseOptions};
use relume::synthesis::pixel::{
    EfrosLeungOptions, NeighbourSearch, PatchMatchOptions, WeiLevoyOptions, efros_leung, patch_match,
    wei_levoy,
};
use relume::synthesis::roller::{RollerOptions, lay, roll};
use relume::synthesis::search::{SearchMethod, SearchOptions};
use relume::synthesis::{Blend, BlockOptions, Boundary, Exemplar, Guidance, Tolerance, gather, synthesize};
use relume::workflow::capture::PhotographFormat;
use relume::workflow::gonioreflectometer::images;
use relume::{Direction, Job, Picture, Planes, Raster, ReflectanceField, Result, Samples, Size, Space};

/// A stage as a function of its job.
type Run = dyn Fn(&Job) -> Result<()> + Sync;

/// Something the library does, by name.
pub struct Stage {
    pub name: &'static str,
    pub run: Box<Run>,
}

/// A stage whose result is dropped.
fn stage<R>(name: &'static str, run: impl Fn(&Job) -> Result<R> + Sync + 'static) -> Stage {
    Stage { name, run: Box::new(move |job| run(job).map(drop)) }
}

/// Planes of a texture that neither repeats nor has a direction: smoothed noise.
pub fn texture(size: Size, count: usize, seed: u64) -> Planes {
    let mut stream = Stream::new(seed, Purpose::Sample, [0]);
    let mut planes = Planes::zeros(size, count);
    for plane in planes.iter_mut() {
        plane.iter_mut().for_each(|v| *v = stream.unit() as f32);
        for _ in 0..2 {
            let before = plane.to_vec();
            for (i, v) in plane.iter_mut().enumerate() {
                let next = |by: usize| before[(i + by) % before.len()];
                *v = 0.25 * (before[i] + next(1) + next(size.width) + next(size.width + 1));
            }
        }
    }
    planes
}

/// A field of polynomials of a luminance times a colour.
pub fn polynomials(size: Size) -> ReflectanceField {
    ReflectanceField::new(Basis::Ptm, PlaneLayout::LRGB, Space::Srgb, texture(size, 9, 1)).unwrap()
}

fn index_of(field: &ReflectanceField) -> Planes {
    IndexSpace::new(field, Metric::Function, Domain::Hemisphere).unwrap().index_planes(field)
}

/// All stages on inputs of `side` x `side` texels.
pub fn all(side: usize) -> Vec<Stage> {
    let mut stages = of_blocks(side);
    stages.extend(of_texels(side));
    stages.extend(of_tiles_and_noise(side));
    stages.extend(of_random_fields(side));
    stages.extend(of_photographs(side));
    stages.extend(of_surfaces(side));
    stages.extend(of_pictures(side));
    stages.extend(of_measures(side));
    stages.extend(of_files(side));
    stages.extend(of_textures_of_light_and_view(side));
    stages
}

fn quilted(name: &'static str, planes: usize, options: BlockOptions, side: usize) -> Stage {
    let index = texture(Size::new(side, side), planes, 2);
    stage(name, move |job| synthesize(&[Exemplar { index: &index, excluded: None }], &options, job))
}

fn of_blocks(side: usize) -> Vec<Stage> {
    let base = BlockOptions { size: Size::new(2 * side, 2 * side), ..BlockOptions::default() };
    let with = |method| BlockOptions { search: SearchOptions { method, ..base.search }, ..base.clone() };
    let cut = BlockOptions { blend: Blend::GraphCut, ..base.clone() };
    let mixed = BlockOptions { blend: Blend::Alpha, ..base.clone() };
    let loose =
        BlockOptions { tolerance: Tolerance::Relative(0.3), boundary: Boundary::Torus, ..base.clone() };
    let guide = texture(Size::new(side, side), 1, 5);
    let target = texture(base.size, 1, 6);
    let guidance = Some(Guidance { sources: vec![guide], target, weight: 1.0 });
    let guided = BlockOptions { guidance, ..base.clone() };
    vec![
        quilted("quilting, projections, 18 planes", 18, with(SearchMethod::Projection), side),
        quilted("quilting, projections, 3 planes", 3, with(SearchMethod::Projection), side),
        quilted("quilting, correlation", 3, with(SearchMethod::Fft), side),
        quilted("quilting, every position", 3, with(SearchMethod::Brute), side / 2),
        quilted("quilting, graph cuts", 3, cut, side),
        quilted("quilting, ramps", 3, mixed, side),
        quilted("quilting, on a torus", 9, loose, side),
        quilted("quilting, guided", 3, BlockOptions { size: base.size, ..guided }, side),
    ]
}

fn of_texels(side: usize) -> Vec<Stage> {
    let (size, half) = (Size::new(side, side), Size::new(side / 2, side / 2));
    let scanned = |name, search| {
        let index = texture(size, 3, 3);
        let options = WeiLevoyOptions { size: half, search, ..WeiLevoyOptions::default() };
        stage(name, move |job| wei_levoy(&[Exemplar { index: &index, excluded: None }], &options, job))
    };
    let (grown, matched, holed) = (texture(half, 3, 3), texture(size, 9, 3), texture(size, 3, 4));
    let growing = EfrosLeungOptions { size: half, ..EfrosLeungOptions::default() };
    let matching = PatchMatchOptions { size, ..PatchMatchOptions::default() };
    let hole = |texel: usize| {
        let near = |at: usize| at.abs_diff(side / 2) < side / 10;
        near(texel % side) && near(texel / side)
    };
    let holes: Vec<bool> = (0..size.texels()).map(hole).collect();
    let band = texture(half, 9, 7);
    let filling = FillOptions::default();
    let texel_filling = FillOptions { method: FillMethod::Texels, ..filling.clone() };
    let also_holed = (holed.clone(), holes.clone());
    vec![
        scanned("scanlines, tree", NeighbourSearch::Tsvq(4096)),
        scanned("scanlines, coherence", NeighbourSearch::Coherence { candidates: 4, codewords: 4096 }),
        scanned("scanlines, continued", NeighbourSearch::Coherence { candidates: 1, codewords: 4096 }),
        stage("growing texels", move |job| {
            efros_leung(&[Exemplar { index: &grown, excluded: None }], &growing, job)
        }),
        stage("patch matching", move |job| {
            patch_match(&[Exemplar { index: &matched, excluded: None }], &matching, job)
        }),
        stage("filling patches", move |job| fill(&holed, &holes, None, &filling, job)),
        stage("filling texels", move |job| fill(&also_holed.0, &also_holed.1, None, &texel_filling, job)),
        stage("closing a border", move |job| {
            let exemplar = Exemplar { index: &band, excluded: None };
            tileable(exemplar, 8, &FillOptions { boundary: Boundary::Torus, ..FillOptions::default() }, job)
        }),
    ]
}

fn of_tiles_and_noise(side: usize) -> Vec<Stage> {
    let size = Size::new(side, side);
    let (regular, laid, plain, field) =
        (texture(size, 9, 8), texture(size, 3, 8), texture(size, 9, 9), polynomials(size));
    let indexed = polynomials(size);
    vec![
        stage("index planes", move |job| {
            let space = IndexSpace::new(&indexed, Metric::Function, Domain::Hemisphere)?;
            space.index_planes_within(&indexed, job, "the index")
        }),
        stage("rolling tiles", move |job| {
            let exemplar = Exemplar { index: &regular, excluded: None };
            roll(&exemplar, &RollerOptions { oblique: true, ..RollerOptions::default() }, job)
        }),
        stage("laying tiles", move |job| {
            let exemplar = Exemplar { index: &laid, excluded: None };
            let rolled = roll(&exemplar, &RollerOptions::default(), job)?;
            let map = lay(&rolled.tiles, Size::new(4 * side, 4 * side), Boundary::Open, 0, job)?;
            Ok(map)
        }),
        stage("blending noise", move |job| {
            let noise = Noise::new(&plain, &NoiseOptions::default(), job)?;
            noise.window(0, 0, Size::new(2 * side, 2 * side), job)
        }),
        stage("gathering", move |job| {
            let index = index_of(&field);
            let exemplars = [Exemplar { index: &index, excluded: None }];
            let options = BlockOptions { size, blend: Blend::Alpha, ..BlockOptions::default() };
            let options = BlockOptions {
                search: SearchOptions { method: SearchMethod::Brute, ..SearchOptions::default() },
                ..options
            };
            let made = synthesize(&exemplars, &options, job)?;
            gather(&made.map, &[&field], job)
        }),
    ]
}

fn of_random_fields(side: usize) -> Vec<Stage> {
    let size = Size::new(side, side);
    let (modelled, run) = (polynomials(size), polynomials(Size::new(128, 128)));
    let options = ModelOptions::default();
    let (model, _) = model_field(&run, &options, &Job::default()).unwrap();
    vec![
        stage("estimating a random field", move |job| model_field(&modelled, &options, job)),
        stage("estimating fewer levels", {
            let picture =
                ReflectanceField::new(Basis::Constant, PlaneLayout::RGB, Space::Srgb, texture(size, 3, 2));
            let (picture, options) = (picture.unwrap(), ModelOptions { fewer: true, ..options });
            move |job| model_field(&picture, &options, job)
        }),
        stage("running a random field", move |job| {
            let size = Size::new(2 * side, 2 * side);
            model.synthesize(&RealisationOptions { origin: [0, 0], size, seed: 0, period: None }, job)
        }),
    ]
}

/// A photograph of noise.
fn photograph(size: Size, number: usize) -> Raster {
    let mut stream = Stream::new(17, Purpose::Sample, [number as u64]);
    let samples = (0..size.texels() * 3).map(|_| (stream.below(200) + 20) as u8).collect();
    Raster::new(size, 3, Samples::U8(samples)).unwrap()
}

fn named_lights(count: usize) -> Vec<(String, Direction)> {
    lights(count).into_iter().enumerate().map(|(i, light)| (format!("{i}.png"), light)).collect()
}

fn of_photographs(side: usize) -> Vec<Stage> {
    let size = Size::new(side, side);
    let maps = Material::Leather
        .make(&MaterialOptions { size, ..MaterialOptions::default() }, &Job::default())
        .unwrap();
    let measured = maps.clone();
    vec![
        stage("fitting", move |job| {
            fit(&named_lights(40), &|i| Ok(photograph(size, i)), &FitOptions::default(), job)
        }),
        stage("fitting, each left out", move |job| {
            let options =
                FitOptions { leave_one_out: true, layout: PlaneLayout::RGB, ..FitOptions::default() };
            fit(&named_lights(24), &|i| Ok(photograph(size, i)), &options, job)
        }),
        stage("making a material", move |job| {
            Material::Sponge.make(&MaterialOptions { size, ..MaterialOptions::default() }, job)
        }),
        stage("photographing", move |job| {
            let dome = Dome::new(maps.clone(), &DomeOptions::default(), job)?;
            dome.photograph_within(Direction::new(0.5, 0.3, 0.8)?, job)
        }),
        stage("measuring pairs of light and view", move |job| {
            let dome = Dome::new(measured.clone(), &DomeOptions::default(), job)?;
            let pairs = [all_pairs(&lights(4), &lights(3)), random_pairs(8, 0)].concat();
            let device = Gonioreflectometer::new(dome, pairs, job)?;
            images(&device, PhotographFormat::Jpeg, job, &mut |_, _| Ok(()))
        }),
    ]
}

fn of_surfaces(side: usize) -> Vec<Stage> {
    let size = Size::new(side, side);
    let slopes = || {
        let mut normals = texture(size, 3, 12);
        normals.plane_mut(2).iter_mut().for_each(|v| *v += 2.0);
        Slopes::from_normals(&normals, STEEPEST).unwrap()
    };
    let (given, luminance) = (slopes(), texture(size, 1, 13));
    vec![
        stage("photometric stereo", move |job| {
            let (lights, load) = (named_lights(12), |i: usize| Ok(photograph(size, i)));
            let input = StereoInput { lights: &lights, lamps: None, load: &load };
            photometric_stereo(input, &StereoOptions::default(), job)
        }),
        stage("integrating slopes", move |job| integrate(&given, &IntegrateOptions::default(), job)),
        stage("shape from shading", move |job| {
            let light = Direction::new(0.6, 0.2, 0.7)?;
            shape_from_shading(
                &luminance,
                light,
                &ShadingOptions { rounds: 30, ..ShadingOptions::default() },
                job,
            )
        }),
    ]
}

fn of_pictures(side: usize) -> Vec<Stage> {
    let size = Size::new(side, side);
    let sphere: fn() -> Mesh = || Primitive::Sphere.mesh();
    let (flat, lifted) = (polynomials(size), polynomials(size));
    let relief = MeshRelief { height: texture(size, 1, 14), displacement: 4.0, bump: 1.0 };
    let options = move || RenderOptions { size: Size::new(2 * side, 2 * side), ..RenderOptions::default() };
    vec![
        stage("rendering", move |job| render(&flat, None, &sphere(), &options(), job)),
        stage("rendering a relief", move |job| {
            render_relief(&lifted, None, Some(&relief), &sphere(), &options(), job)
        }),
    ]
}

fn of_measures(side: usize) -> Vec<Stage> {
    let size = Size::new(side, side);
    let pair = move || (texture(size, 9, 15), texture(size, 9, 16));
    let (patches, spectra, pyramids, analysed) = (pair(), pair(), pair(), texture(size, 9, 17));
    vec![
        stage("patch distance", move |job| {
            sliced::levels(&patches.0, &patches.1, &SlicedOptions::default(), job)
        }),
        stage("power spectrum", move |job| spectrum::distance_db(&spectra.0, &spectra.1, job)),
        stage("steerable pyramid", move |job| steerable::distance(&pyramids.0, &pyramids.1, job)),
        stage("analysing", move |job| analyze(&analysed, job)),
    ]
}

/// Pictures of an animation.
fn frames(size: Size) -> Vec<Picture> {
    (0..4).map(|seed| Picture { planes: texture(size, 3, 20 + seed), space: Space::Srgb }).collect()
}

fn of_files(side: usize) -> Vec<Stage> {
    let size = Size::new(side, side);
    let functions = [
        ("a .ptm", FieldFormat::Ptm),
        ("an EXR field", FieldFormat::Exr(ExrDepth::Float)),
        ("an EXR field of halves", FieldFormat::Exr(ExrDepth::Half)),
    ];
    let pictures = [
        ("a PNG", PictureFormat::Png(Depth::Eight)),
        ("a PNG of 16 bits", PictureFormat::Png(Depth::Sixteen)),
        ("a TIFF", PictureFormat::Tiff(Depth::Sixteen)),
        ("a JPEG", PictureFormat::Jpeg { quality: 90 }),
    ];
    let pictures = pictures.map(|(name, format)| (name, FieldFormat::Picture(format)));
    let (frames, heights) = (frames(size), texture(size, 1, 19));
    let (also_frames, also_heights) = (frames.clone(), heights.clone());
    let mut stages = vec![
        stage("writing an animated PNG", move |job| encode_apng_with(&frames, 10, job)),
        stage("writing an animated GIF", move |job| encode_gif_with(&also_frames, 10, job)),
        stage("writing heights as a PNG", move |job| {
            encode_height_with(&heights, None, HeightFormat::Png, job)
        }),
        stage("writing heights as EXR", move |job| {
            encode_height_with(&also_heights, Some(0.1), HeightFormat::Exr, job)
        }),
    ];
    for (name, format) in functions.into_iter().chain(pictures) {
        let field = if matches!(format, FieldFormat::Picture(_)) {
            ReflectanceField::new(Basis::Constant, PlaneLayout::RGB, Space::Srgb, texture(size, 3, 18))
                .unwrap()
        } else {
            polynomials(size)
        };
        let bytes = encode_field(&field, format, None, &Job::default()).unwrap();
        stages.push(stage(leaked(&format!("writing {name}")), move |job| {
            encode_field(&field, format, None, job)
        }));
        stages.push(stage(leaked(&format!("reading {name}")), move |job| decode_field(&bytes, job)));
    }
    stages
}

/// Factors of a texture of light and view: 16 x 16 pairs.
fn factors_of(side: usize, shape: FactorShape, rows: usize) -> BtfFactors {
    let (count, size) = (8, Size::new(side, side));
    let functions = texture(Size::new(count, rows), 1, 21).as_slice().to_vec();
    BtfFactors { shape, functions, coefficients: texture(size, count, 22), singular: vec![1.0; count] }
}

fn of_textures_of_light_and_view(side: usize) -> Vec<Stage> {
    let direction = |i: usize| Direction::from_angles(0.08 * i as f64, i as f64);
    let pair = |i: usize| Directions { light: direction(i % 16), view: direction(i / 16) };
    let pairs: Vec<Directions> = (0..256).map(pair).collect();
    let all = factors_of(side, FactorShape::Functions, 3 * 256);
    let channels = [(); 3].map(|()| factors_of(side, FactorShape::Coefficients, 256));
    let model = BtfColorModel::LogYRatios;
    let fmf = Arc::new(encode_fmf(&pairs, &all, BtfScalar::Half, &Job::default()).unwrap());
    let dfmf = encode_dfmf(&pairs, &channels, model, BtfScalar::Half, &Job::default()).unwrap();
    let [decoded, linear] =
        [&dfmf, &*fmf].map(|bytes| BonnBtf::decode(Arc::new(bytes.clone()), &Job::default()).unwrap());
    let also_pairs = pairs.clone();
    vec![
        stage("writing the factors of a BTF", move |job| encode_fmf(&pairs, &all, BtfScalar::Half, job)),
        stage("writing the factored channels of a BTF", move |job| {
            encode_dfmf(&also_pairs, &channels, model, BtfScalar::Half, job)
        }),
        stage("reading the factors of a BTF", move |job| BonnBtf::decode(Arc::clone(&fmf), job)),
        stage("the image of a factored BTF", move |job| decoded.planes(77, job)),
        stage("the basis of a factored BTF", move |job| linear.linear_factors(job)),
    ]
}

fn leaked(name: &str) -> &'static str {
    Box::leak(name.to_owned().into_boxed_str())
}
