//! `.rlm`: a random-field model in a few kilobytes. `docs/formats.md` has the layout.
//!
//! The file represents the model exactly: reading restores it to the bit.

mod bits;
mod functions;
mod read;
mod structure;
mod table;
mod write;

pub use functions::{decode_functions, encode_functions, functions_bytes};
pub use read::decode;
pub use structure::structure_bytes;
pub use write::{check_kind, encode};

/// First bytes of the file.
const SIGNATURE: [u8; 4] = *b"RLM\x1a";

/// The versions of the layout: without a structure, with one, with heights or one model per light, with the
/// joint distribution of a colour, with learned functions, and with one model for each cluster of photographs.
const VERSIONS: [u8; 6] = [1, 2, 3, 4, 5, 6];

/// Added to the version of a model whose detail depends on the place.
const WITH_LOCAL_DETAIL: u8 = 16;

/// The layout of a file.
#[derive(Debug, Clone, Copy)]
struct Edition {
    /// One of [`VERSIONS`].
    version: u8,
    /// Whether gains from place to place follow the levels, and the structure predicts the detail.
    has_local_detail: bool,
}

/// Signature, version, checksum and length of the rest.
const HEADER: usize = 4 + 1 + 4 + 4;

/// The most candidate neighbours of a mask.
const MOST_CANDIDATES: usize = 511;

/// The CRC-32 of IEEE 802.3: it detects every single altered byte.
fn checksum(bytes: &[u8]) -> u32 {
    let byte = |sum: u32, byte: &u8| {
        (0..8).fold(sum ^ u32::from(*byte), |s, _| (s >> 1) ^ (0xedb8_8320 & (s & 1).wrapping_neg()))
    };
    !bytes.iter().fold(u32::MAX, byte)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::basis::learned_of_channels_example;
    use crate::field::{Basis, PackedFunctions, PlaneLayout};
    use crate::job::Job;
    use crate::limits::Limits;
    use crate::numeric::random::{Purpose, Stream};
    use crate::planes::Planes;
    use crate::random_field::{
        Budget, FieldModel, Fields, Heights, Model, ModelOptions, PhotographClusters, RealisationOptions,
        Tiles, combine_field, estimate, model_field, model_lights,
    };
    use crate::size::Size;
    use crate::{ReflectanceField, Space};

    fn job() -> Job {
        Job::new(Limits { max_bytes: 1 << 28, max_side: 1 << 14 })
    }

    fn model(basis: Basis, color: PlaneLayout, marginals: bool) -> FieldModel {
        let (size, mut stream) = (Size::new(36, 30), Stream::new(5, Purpose::Sample, [0]));
        let count = color.planes(basis.len());
        let data = (0..size.texels() * count).map(|_| stream.unit() as f32 + 0.1).collect();
        let planes = Planes::from_vec(size, count, data).unwrap();
        let field = ReflectanceField::new(basis, color, Space::Srgb, planes).unwrap();
        let options = ModelOptions { levels: 2, candidates: 6, coarse: 5, marginals, ..Default::default() };
        model_field(&field, &options, &job()).unwrap().0
    }

    /// The same with a structure of two tiles.
    fn combined() -> FieldModel {
        let (size, mut stream) = (Size::new(20, 24), Stream::new(9, Purpose::Sample, [0]));
        let data =
            (0..size.texels() * 3).map(|i| 0.3 + (i % 5) as f32 * 0.1 + 0.1 * stream.unit() as f32).collect();
        let planes = Planes::from_vec(size, 3, data).unwrap();
        let field = ReflectanceField::new(Basis::Constant, PlaneLayout::RGB, Space::Srgb, planes).unwrap();
        let options = ModelOptions { levels: 2, candidates: 4, coarse: 5, ..Default::default() };
        let tiles = Tiles { texels: &field, size: Size::new(20, 12) };
        let budget = Budget { bytes: 250, cost: &structure_bytes };
        combine_field(&field, tiles, &budget, &options, &job()).unwrap().0
    }

    /// The version of a file, whether detail depends on the place or not.
    fn version(bytes: &[u8]) -> u8 {
        bytes[4] & !WITH_LOCAL_DETAIL
    }

    fn joint(model: &FieldModel) -> &Model {
        let Fields::Joint(model) = &model.fields else { panic!("one model") };
        model
    }

    /// A field with one model for each of seven lights.
    fn per_light(color: PlaneLayout) -> FieldModel {
        let (size, mut stream) = (Size::new(30, 24), Stream::new(6, Purpose::Sample, [0]));
        let count = color.planes(Basis::Ptm.len());
        let data = (0..size.texels() * count).map(|_| stream.unit() as f32 + 0.1).collect();
        let planes = Planes::from_vec(size, count, data).unwrap();
        let field = ReflectanceField::new(Basis::Ptm, color, Space::Srgb, planes).unwrap();
        let options = ModelOptions { levels: 1, candidates: 4, ..Default::default() };
        let lights = crate::capture::dome::lights(7);
        let picture = |light| crate::render::relight(&field, light).planes;
        model_lights(&field, &lights, &picture, &options, &job()).unwrap().0
    }

    /// A height map whose texels have a size.
    fn heights(mm_per_texel: Option<f64>, combined: bool) -> FieldModel {
        let (size, mut stream) = (Size::new(24, 24), Stream::new(2, Purpose::Sample, [0]));
        let data = (0..size.texels()).map(|_| stream.unit() as f32).collect();
        let planes = Planes::from_vec(size, 1, data).unwrap();
        let field =
            ReflectanceField::new(Basis::Constant, PlaneLayout::LUMINANCE, Space::Linear, planes).unwrap();
        let options = ModelOptions { levels: 1, candidates: 4, ..Default::default() };
        let tiles = Tiles { texels: &field, size };
        let budget = Budget { bytes: 200, cost: &structure_bytes };
        let made = match combined {
            true => combine_field(&field, tiles, &budget, &options, &job()),
            false => model_field(&field, &options, &job()),
        };
        FieldModel { heights: Some(Heights { mm_per_texel }), ..made.unwrap().0 }
    }

    #[test]
    fn models_of_lights_and_of_heights_come_back_equal_and_make_the_same() {
        let colors = [PlaneLayout::LUMINANCE, PlaneLayout::RGB, PlaneLayout::LRGB];
        let heights = [(None, false), (Some(0.1), false), (Some(1e-3), true)].map(|(mm, c)| heights(mm, c));
        for model in colors.into_iter().map(per_light).chain(heights) {
            let bytes = encode(&model).unwrap();
            let back = decode(&bytes, &job()).unwrap();
            assert_eq!(&back, &model);
            assert_eq!(version(&bytes), if model.layout == PlaneLayout::LUMINANCE { 3 } else { 4 });
            let options =
                RealisationOptions { origin: [-9, 3], size: Size::new(20, 10), seed: 3, period: None };
            let made = model.synthesize(&options, &job()).unwrap();
            assert_eq!(
                (made.basis(), made.layout(), made.size()),
                (&model.basis, &model.layout, options.size)
            );
            assert_eq!(back.synthesize(&options, &job()).unwrap(), made);
        }
    }

    #[test]
    fn a_structure_comes_back_and_keeps_to_its_bytes() {
        let model = combined();
        let bytes = encode(&model).unwrap();
        assert_eq!((bytes[4], decode(&bytes, &job()).unwrap()), (4 + WITH_LOCAL_DETAIL, model.clone()));
        let structure = joint(&model).structure.clone().unwrap();
        assert!((200..=250).contains(&structure_bytes(&structure)), "{}", structure_bytes(&structure));
        let mut plain = model;
        let Fields::Joint(field) = &mut plain.fields else { panic!("one model") };
        field.structure = None;
        let levels = field.levels.len();
        let without = encode(&plain).unwrap();
        assert_eq!(version(&without), 4);
        // Without a structure and gains, there are no bits for gains either.
        let local = if without[4] == bytes[4] { 0 } else { (9 * levels).div_ceil(8) };
        assert!((bytes.len() - without.len() - local).abs_diff(structure_bytes(&structure)) <= 1);
    }

    #[test]
    fn models_of_former_versions_keep_a_detail_that_does_not_depend_on_the_place() {
        let new = combined();
        let mut former = new.clone();
        let Fields::Joint(field) = &mut former.fields else { panic!("one model") };
        assert!(field.levels.iter().any(|level| !level.coarse.is_empty()), "something to predict");
        field.structure.as_mut().unwrap().predicts = false;
        field.levels.iter_mut().for_each(|level| (level.gain, level.unevenness) = (None, 0));
        let bytes = encode(&former).unwrap();
        let back = decode(&bytes, &job()).unwrap();
        assert_eq!((bytes[4], &back), (4, &former));
        let made = |model: &FieldModel| model.synthesize(&window(), &job()).unwrap();
        assert_eq!(made(&back), made(&former));
        assert_ne!(made(&back), made(&new));
    }

    #[test]
    fn models_that_the_file_has_no_name_for_are_refused() {
        let channels = PlaneLayout::of_channels(["base", "height"]).unwrap();
        let named = model(Basis::Constant, channels, true);
        assert!(encode(&named).unwrap_err().to_string().contains("not of channels constant"));
        let learned = model(Basis::examples().pop().unwrap(), PlaneLayout::LUMINANCE, true);
        assert!(encode(&learned).unwrap_err().to_string().contains("are not packed"));
    }

    /// A part of the plane of a model.
    fn window() -> RealisationOptions {
        RealisationOptions { origin: [-9, 3], size: Size::new(20, 10), seed: 3, period: None }
    }

    /// A model of functions of light and view.
    fn of_light_and_view(channels: usize) -> FieldModel {
        let learned = learned_of_channels_example(channels, 7, 5, 3);
        let packed = PackedFunctions::new(&learned, &[0.01, 0.02, 0.05]).unwrap();
        let layout = PlaneLayout::shared(["R", "G", "B"].into_iter().take(channels)).unwrap();
        let layout = if channels == 1 { PlaneLayout::LUMINANCE } else { layout };
        model(Basis::Learned(packed.unpacked().unwrap()), layout, true)
    }

    #[test]
    fn models_of_learned_functions_come_back_equal_and_make_the_same() {
        for model in [1, 3].map(of_light_and_view) {
            let bytes = encode(&model).unwrap();
            let back = decode(&bytes, &job()).unwrap();
            assert_eq!((version(&bytes), &back), (5, &model));
            assert_eq!(
                (model.source.photographs, model.source_bytes()),
                (35, 35 * 36 * 30 * u64::from(model.source.channels))
            );
            assert_eq!(encode(&back).unwrap(), bytes);
            let made = |model: &FieldModel| model.synthesize(&window(), &job()).unwrap();
            assert_eq!(made(&back), made(&model));
        }
    }

    #[test]
    fn the_checksum_is_the_usual_one() {
        assert_eq!(checksum(b"123456789"), 0xcbf4_3926);
    }

    #[test]
    fn models_come_back_equal_and_make_the_same() {
        for (basis, color) in [
            (Basis::Constant, PlaneLayout::RGB),
            (Basis::Constant, PlaneLayout::LUMINANCE),
            (Basis::Ptm, PlaneLayout::LRGB),
            (Basis::Ptm, PlaneLayout::RGB),
            (Basis::HSH9, PlaneLayout::LRGB),
        ] {
            for marginals in [true, false] {
                let model = model(basis.clone(), color.clone(), marginals);
                let back = decode(&encode(&model).unwrap(), &job()).unwrap();
                assert_eq!(back, model, "{basis:?} {color:?}");
                let options = window();
                let made = model.synthesize(&options, &job()).unwrap();
                assert_eq!((made.basis(), made.layout(), made.size()), (&basis, &color, options.size));
                assert_eq!(back.synthesize(&options, &job()).unwrap(), made);
            }
        }
    }

    /// A model of clusters of photographs, with a range map.
    fn of_clusters(channels: usize) -> FieldModel {
        let (size, mut stream) = (Size::new(30, 24), Stream::new(6, Purpose::Sample, [0]));
        let mut model = |planes: usize| {
            let data = (0..size.texels() * planes).map(|_| stream.unit() as f32 + 0.1).collect();
            let planes = Planes::from_vec(size, planes, data).unwrap();
            let color = (planes.count() == 3).then_some(0);
            let options = ModelOptions { levels: 1, candidates: 4, color, ..Default::default() };
            estimate(&planes, &options, &job()).unwrap().0
        };
        let models: Vec<Model> = (0..3).map(|_| model(channels)).collect();
        let range = Some(Box::new(model(1)));
        let learned = learned_of_channels_example(1, 7, 5, 3);
        let packed = PackedFunctions::new(&learned, &[0.1; 3]).unwrap();
        // Each pair has one function.
        let pairs = 35;
        let code = |i: usize| if i / pairs == (i % pairs * 5 / 7) % 3 { 20 + (i % 7) as i32 } else { 0 };
        let table = PackedFunctions { codes: (0..3 * pairs).map(code).collect(), ..packed };
        FieldModel::of_clusters(table, Space::Srgb, PhotographClusters { models, range }, size).unwrap()
    }

    #[test]
    fn models_of_clusters_come_back_equal_and_make_the_same() {
        for model in [1, 3].map(of_clusters) {
            let bytes = encode(&model).unwrap();
            let back = decode(&bytes, &job()).unwrap();
            assert_eq!((version(&bytes), &back), (6, &model));
            assert_eq!(encode(&back).unwrap(), bytes);
            let made = |model: &FieldModel| model.synthesize(&window(), &job()).unwrap();
            assert_eq!(made(&back), made(&model));
            let heights = |model: &FieldModel| model.range_map(&window(), &job()).unwrap().unwrap();
            assert_eq!(heights(&back), heights(&model));
        }
    }

    /// A model of each kind.
    fn examples() -> [FieldModel; 6] {
        let plain = model(Basis::Constant, PlaneLayout::RGB, true);
        [
            plain,
            combined(),
            per_light(PlaneLayout::LUMINANCE),
            heights(Some(0.1), false),
            of_light_and_view(3),
            of_clusters(3),
        ]
    }

    #[test]
    fn a_file_cut_anywhere_or_altered_in_any_byte_is_refused() {
        for model in examples() {
            let bytes = encode(&model).unwrap();
            for length in 0..bytes.len() {
                assert!(decode(&bytes[..length], &job()).is_err(), "cut at {length}");
            }
            for place in 0..bytes.len() {
                for change in [1, WITH_LOCAL_DETAIL, 0x80, 0xff] {
                    let mut altered = bytes.clone();
                    altered[place] ^= change;
                    assert!(decode(&altered, &job()).is_err(), "byte {place} changed by {change}");
                }
            }
            assert!(decode(&[&bytes[..], b"x"].concat(), &job()).is_err());
        }
    }

    /// How many of 400 files altered at random, with corrected checksums, are refused, and how many make
    /// something.
    fn forged(bytes: &[u8]) -> [usize; 2] {
        let mut stream = Stream::new(1, Purpose::Sample, [0]);
        let mut counts = [0; 2];
        for _ in 0..400 {
            let mut forged = bytes.to_vec();
            for _ in 0..1 + stream.below(3) {
                let place = HEADER + stream.below(bytes.len() - HEADER);
                forged[place] = stream.below(256) as u8;
            }
            let sum = checksum(&forged[9..]);
            forged[5..9].copy_from_slice(&sum.to_le_bytes());
            let options = RealisationOptions { origin: [0, 0], size: Size::new(3, 2), seed: 3, period: None };
            let made = decode(&forged, &job()).and_then(|model| model.synthesize(&options, &job()));
            counts[usize::from(made.is_ok())] += 1;
        }
        counts
    }

    #[test]
    fn forged_files_with_a_right_checksum_are_refused_or_make_something() {
        for model in examples() {
            let [refused, made] = forged(&encode(&model).unwrap());
            assert!(refused > 20 && made > 20, "{refused} refused, {made} made");
        }
    }
}
