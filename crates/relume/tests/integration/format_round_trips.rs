//! Everything written is read back: values, spaces, colour models, lights, depths.

use relume::field::{Basis, PlaneLayout};
use relume::format::exr::{decode_labelled, encode_labelled};
use relume::format::{
    Depth, Encoding, ExrDepth, FieldFormat, PictureFormat, decode_field, decode_raster, encode_field,
    encode_picture,
};
use relume::numeric::random::{Purpose, Stream};
use relume::{Direction, ErrorKind, Picture, Planes, Raster, ReflectanceField, Samples, Size, Space};

use crate::support::{job, random_field};

const SIZE: Size = Size { width: 13, height: 9 };
const FLOAT: FieldFormat = FieldFormat::Exr(ExrDepth::Float);

fn all_fields() -> impl Iterator<Item = ReflectanceField> {
    Basis::examples().into_iter().flat_map(move |basis| {
        PlaneLayout::examples(&basis).into_iter().flat_map(move |layout| {
            let kind = (basis.clone(), layout);
            let field = move |space| random_field(kind.0.clone(), kind.1.clone(), space, SIZE, 1);
            [Space::Linear, Space::Srgb].into_iter().map(field)
        })
    })
}

#[test]
fn every_field_comes_back_from_exr_bit_by_bit() {
    for mut field in all_fields() {
        let odd = [f32::MIN_POSITIVE / 8.0, -0.0, 3e38, -3e38, f32::from_bits(1)];
        let mut planes = field.coefficients().clone();
        planes.as_mut_slice()[..5].copy_from_slice(&odd);
        let lights =
            vec![Direction::from_disk(0.3, -0.2), Direction::ZENITH, Direction::from_angles(1.0, 2.0)];
        field = field.with_coefficients(planes).unwrap().with_lights(lights);
        let file = encode_field(&field, FLOAT, None, &job()).unwrap();
        let read = decode_field(&file, &job()).unwrap();
        assert_eq!(read.encoding, Encoding::Exr(ExrDepth::Float));
        let kind = |f: &ReflectanceField| (f.basis().clone(), f.layout().clone(), f.space(), f.size());
        assert!(kind(&read.field) == kind(&field), "{} {:?}", field.basis().name(), field.layout());
        let bits = |f: &ReflectanceField| -> Vec<u32> {
            f.coefficients().as_slice().iter().map(|v| v.to_bits()).collect()
        };
        assert_eq!(bits(&read.field), bits(&field));
        assert_eq!(read.field.lights().len(), 3);
        for (a, b) in read.field.lights().iter().zip(field.lights()) {
            assert!(a.dot(*b) > 1.0 - 1e-14);
        }
    }
}

#[test]
fn halves_come_back_as_the_same_halves() {
    for field in all_fields() {
        let half = FieldFormat::Exr(ExrDepth::Half);
        let first = decode_field(&encode_field(&field, half, None, &job()).unwrap(), &job()).unwrap();
        for (a, b) in first.field.coefficients().as_slice().iter().zip(field.coefficients().as_slice()) {
            assert!((a - b).abs() <= b.abs() / 2048.0 + 1e-7);
        }
        assert_eq!(first.encoding, Encoding::Exr(ExrDepth::Half));
        assert_eq!(FLOAT.in_depth_of(&first.encoding), half);
        let second = decode_field(&encode_field(&first.field, half, None, &job()).unwrap(), &job()).unwrap();
        assert_eq!(second, first);
    }
}

#[test]
fn a_file_is_a_function_of_its_content() {
    let field = random_field(Basis::Ptm, PlaneLayout::RGB, Space::Linear, Size::new(64, 100), 4)
        .with_lights(vec![Direction::ZENITH]);
    let encoded = random_field(Basis::Ptm, PlaneLayout::LRGB, Space::Srgb, Size::new(64, 100), 4);
    let first = encode_field(&field, FLOAT, None, &job()).unwrap();
    let first_ptm = encode_field(&encoded, FieldFormat::Ptm, None, &job()).unwrap();
    for threads in [1, 2, 3, 8] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            for _ in 0..4 {
                assert_eq!(encode_field(&field, FLOAT, None, &job()).unwrap(), first);
                assert_eq!(encode_field(&encoded, FieldFormat::Ptm, None, &job()).unwrap(), first_ptm);
            }
        });
    }
}

/// A raster with every kind of code.
fn raster(channels: usize, depth: Depth) -> Raster {
    let mut random = Stream::new(6, Purpose::Sample, [channels as u64]);
    let n = SIZE.texels() * channels;
    let samples = match depth {
        Depth::Eight => Samples::U8((0..n).map(|_| random.below(256) as u8).collect()),
        Depth::Sixteen => Samples::U16((0..n).map(|_| random.below(65536) as u16).collect()),
    };
    Raster::new(SIZE, channels, samples).unwrap()
}

#[test]
fn integer_pictures_keep_their_codes() {
    for channels in [1, 3] {
        for depth in [Depth::Eight, Depth::Sixteen] {
            let truth = raster(channels, depth);
            for format in [PictureFormat::Png(depth), PictureFormat::Tiff(depth)] {
                let encoded = encode_picture(&truth.to_picture(Space::Srgb), format).unwrap();
                assert_eq!(decode_raster(&encoded, &job()).unwrap(), truth, "{format:?}");
                let linear = encode_picture(&truth.to_picture(Space::Linear), format).unwrap();
                assert_eq!(linear, encoded, "linear light is encoded again, {format:?}");

                let file = decode_field(&encoded, &job()).unwrap();
                assert_eq!((file.field.space(), file.encoding), (Space::Srgb, Encoding::Picture(depth)));
                let eight = match format {
                    PictureFormat::Png(_) => PictureFormat::Png(Depth::Eight),
                    _ => PictureFormat::Tiff(Depth::Eight),
                };
                let again = FieldFormat::Picture(eight).in_depth_of(&file.encoding);
                assert_eq!(encode_field(&file.field, again, Some(&file.encoding), &job()).unwrap(), encoded);
            }
        }
    }
}

#[test]
fn exr_pictures_are_linear_floats() {
    for channels in [1, 3] {
        let picture = raster(channels, Depth::Eight).to_picture(Space::Srgb);
        let file = encode_picture(&picture, PictureFormat::Exr(ExrDepth::Float)).unwrap();
        let read = decode_raster(&file, &job()).unwrap();
        assert_eq!(read.samples().space(), Space::Linear);
        assert_eq!(read.to_picture(Space::Linear), picture.to_space(Space::Linear));
        let field = decode_field(&file, &job()).unwrap().field;
        assert_eq!((field.basis(), field.space()), (&Basis::Constant, Space::Linear));
        let as_field = encode_field(&field, FLOAT, None, &job()).unwrap();
        assert_eq!(decode_raster(&as_field, &job()).unwrap(), read, "linear constants are a picture");
    }
}

#[test]
fn named_channels_come_back_in_alphabetical_order() {
    let planes =
        Planes::from_vec(Size::new(2, 2), 3, (0..12).map(|i| i as f32 * 1e4 + 0.5).collect()).unwrap();
    let file = encode_labelled(&["normal.X", "height_mm", "albedo.R"], &planes, ExrDepth::Float).unwrap();
    let (names, read) = decode_labelled(&file, &job()).unwrap();
    assert_eq!(names, ["albedo.R", "height_mm", "normal.X"]);
    for (ours, theirs) in [(0, 2), (1, 1), (2, 0)] {
        assert_eq!(read.plane(ours), planes.plane(theirs));
    }
    for bad in [vec!["a", "b"], vec!["a", "b", "a"], vec!["a", "b", ""], vec!["a", "b", "\u{3b1}"]] {
        assert!(encode_labelled(&bad, &planes, ExrDepth::Half).is_err(), "{bad:?}");
    }
}

#[test]
fn formats_refuse_what_they_cannot_hold() {
    let field = |basis, space| random_field(basis, PlaneLayout::RGB, space, SIZE, 1);
    let usage = |field: &ReflectanceField, format: FieldFormat, hint: &str| {
        let error = encode_field(field, format, None, &job()).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::Usage);
        assert!(error.message().contains(hint), "{error}");
    };
    usage(&field(Basis::Ptm, Space::Linear), FieldFormat::Ptm, "linear");
    usage(&field(Basis::Constant, Space::Srgb), FieldFormat::Ptm, "constant");
    let png = FieldFormat::Picture(PictureFormat::Png(Depth::Eight));
    usage(&field(Basis::Ptm, Space::Srgb), png, "relight");

    let mut planes = field(Basis::Ptm, Space::Srgb).coefficients().clone();
    planes.plane_mut(7)[SIZE.index(4, 2)] = f32::NAN;
    let broken = field(Basis::Ptm, Space::Srgb).with_coefficients(planes).unwrap();
    let error = encode_field(&broken, FieldFormat::Ptm, None, &job()).unwrap_err();
    assert!(error.message().contains("plane 7 is NaN at texel (4, 2)"), "{error}");
}

#[test]
fn extensions_choose_formats() {
    let field = |name: &str| FieldFormat::from_path(name.as_ref());
    assert_eq!(field("a/b.PTM").unwrap(), FieldFormat::Ptm);
    assert_eq!(field("b.exr").unwrap(), FLOAT);
    assert_eq!(field("b.png").unwrap(), FieldFormat::Picture(PictureFormat::Png(Depth::Eight)));
    assert!(field("b.btf").is_err() && field("b").is_err());
    let picture = |name: &str| PictureFormat::from_path(name.as_ref());
    assert!(matches!(picture("x.JPeG").unwrap(), PictureFormat::Jpeg { .. }));
    assert_eq!(picture("x.tif").unwrap(), PictureFormat::Tiff(Depth::Eight));
    assert_eq!(picture("x.bmp").unwrap_err().kind(), ErrorKind::Usage);
}

#[test]
fn jpeg_is_near_and_refuses_what_it_cannot_hold() {
    let size = Size::new(40, 24);
    let smooth = |c: usize| (0..size.texels()).map(move |i| ((i % 40) as f32 / 40.0 + c as f32 * 0.2) / 1.5);
    let planes = Planes::from_vec(size, 3, (0..3).flat_map(smooth).collect()).unwrap();
    let picture = Picture { planes, space: Space::Srgb };
    let file = encode_picture(&picture, PictureFormat::Jpeg { quality: 95 }).unwrap();
    let read = decode_raster(&file, &job()).unwrap().to_picture(Space::Srgb);
    for (a, b) in read.planes.as_slice().iter().zip(picture.planes.as_slice()) {
        assert!((a - b).abs() < 0.03, "{a} {b}");
    }
    assert!(encode_picture(&picture, PictureFormat::Jpeg { quality: 0 }).is_err());
    let long = Picture { planes: Planes::zeros(Size::new(65_536, 1), 1), space: Space::Srgb };
    let error = encode_picture(&long, PictureFormat::Jpeg { quality: 90 }).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Usage);
}
