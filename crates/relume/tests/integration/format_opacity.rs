//! Opacity and named channels: nothing of a file is dropped or guessed without a word.

use relume::field::{Basis, PlaneLayout};
use relume::format::exr::encode_labelled;
use relume::format::{
    Depth, ExrDepth, FieldFormat, PictureFormat, decode_field, decode_raster, encode_translucent, open,
};
use relume::{ErrorKind, Job, Picture, Planes, ReflectanceField, Samples, Size, Space};

use crate::support::{job, random_field};

const SIZE: Size = Size::new(3, 2);

/// Codes of 8 bits as values.
fn planes(channels: usize, code: impl Fn(usize) -> u8) -> Planes {
    let values = (0..SIZE.texels() * channels).map(|i| f32::from(code(i)) / 255.0).collect();
    Planes::from_vec(SIZE, channels, values).unwrap()
}

fn picture(channels: usize, space: Space) -> ReflectanceField {
    ReflectanceField::from_picture(Picture { planes: planes(channels, |i| (i * 13 + 5) as u8), space })
}

#[test]
fn opacity_comes_back_from_every_format_that_holds_it() {
    let opacity = planes(1, |i| (i * 51) as u8);
    for channels in [1, 3] {
        for format in [
            FieldFormat::Picture(PictureFormat::Png(Depth::Eight)),
            FieldFormat::Picture(PictureFormat::Png(Depth::Sixteen)),
            FieldFormat::Picture(PictureFormat::Tiff(Depth::Eight)),
            FieldFormat::Picture(PictureFormat::Tiff(Depth::Sixteen)),
            FieldFormat::Exr(ExrDepth::Float),
        ] {
            let field = picture(channels, Space::Srgb);
            let file = encode_translucent(&field, Some(&opacity), format, None, &job()).unwrap();
            let read = decode_field(&file, &job()).unwrap();
            assert_eq!(read.opacity.as_ref(), Some(&opacity), "{channels} {format:?}");
            assert_eq!(read.field.coefficients().plane(0), field.coefficients().plane(0), "{format:?}");
            assert_eq!(read.transparent().unwrap(), [true, false, false, false, false, false]);
        }
        let jpeg = FieldFormat::Picture(PictureFormat::Jpeg { quality: 90 });
        let error = encode_translucent(&picture(channels, Space::Srgb), Some(&opacity), jpeg, None, &job());
        assert!(error.unwrap_err().message().contains("hold no opacity"));
    }
}

#[test]
fn exr_colours_are_divided_by_their_opacity_and_multiplied_again() {
    let stored = Planes::from_vec(Size::new(3, 1), 2, vec![0.5, 0.0, 1.0, 0.25, 7.0, 0.5]).unwrap();
    let file = encode_labelled(&["A", "Y"], &stored, ExrDepth::Half).unwrap();
    let raster = decode_raster(&file, &job()).unwrap();
    assert_eq!(raster.samples(), &Samples::F32(vec![0.5, 7.0, 0.5]));
    assert_eq!(raster.opacity(), Some(&Samples::F32(vec![0.5, 0.0, 1.0])));
    let read = decode_field(&file, &job()).unwrap();
    let format = FieldFormat::Exr(ExrDepth::Half);
    let again = encode_translucent(&read.field, read.opacity.as_ref(), format, None, &job()).unwrap();
    assert_eq!(decode_field(&again, &job()).unwrap(), read);
    let raw = open_labelled(&again);
    assert_eq!(raw, stored, "other programs find associated colours");
}

fn open_labelled(file: &[u8]) -> Planes {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    std::fs::write(&path, file).unwrap();
    open(&path, &job()).unwrap().into_labelled().unwrap().1
}

#[test]
fn functions_keep_an_opacity_beside_them() {
    let opacity = planes(1, |i| (i * 51) as u8);
    let format = FieldFormat::Exr(ExrDepth::Float);
    let named = PlaneLayout::of_channels(["height", "roughness"]).unwrap();
    for (basis, layout) in [(Basis::Ptm, PlaneLayout::RGB), (Basis::Constant, named)] {
        let field = random_field(basis, layout, Space::Srgb, SIZE, 1);
        let file = encode_translucent(&field, Some(&opacity), format, None, &job()).unwrap();
        let read = decode_field(&file, &job()).unwrap();
        assert!(read.field == field && read.opacity.as_ref() == Some(&opacity));
    }
}

#[test]
fn a_grey_texture_of_encoded_values_in_exr_is_no_linear_picture() {
    let format = FieldFormat::Exr(ExrDepth::Float);
    for channels in [1, 3] {
        let file = encode_translucent(&picture(channels, Space::Srgb), None, format, None, &job()).unwrap();
        let error = decode_raster(&file, &job()).unwrap_err();
        assert!(error.message().contains("texture of functions"), "{error}");
    }
}

#[test]
fn channels_that_are_left_out_are_named() {
    let stored = Planes::zeros(SIZE, 5);
    for (names, word) in [
        (["B", "G", "R", "Z", "id"], "Z, id are not"),
        (["a.B", "a.G", "a.R", "b.X", "b.Y"], "b.X, b.Y are not"),
    ] {
        let file = encode_labelled(&names, &stored, ExrDepth::Half).unwrap();
        let listening = Job::default();
        assert_eq!(decode_raster(&file, &listening).unwrap().channels(), 3);
        assert!(listening.remarks()[0].contains(word), "{:?}", listening.remarks());
    }
    let layers = Planes::zeros(SIZE, 6);
    let file = encode_labelled(&["a.B", "a.G", "a.R", "b.B", "b.G", "b.R"], &layers, ExrDepth::Half).unwrap();
    let error = decode_raster(&file, &job()).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Unsupported);
    assert!(error.message().contains("a.B, a.G") && error.message().contains("export"), "{error}");
}

#[test]
fn a_reader_without_use_for_opacity_says_so_with_the_files_name() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("leaf.png");
    let format = FieldFormat::Picture(PictureFormat::Png(Depth::Eight));
    let opacity = planes(1, |i| (i * 51) as u8);
    let file = encode_translucent(&picture(3, Space::Srgb), Some(&opacity), format, None, &job()).unwrap();
    std::fs::write(&path, file).unwrap();
    let listening = Job::default();
    assert!(open(&path, &listening).unwrap().into_exemplar().unwrap().opacity.is_some());
    assert!(listening.remarks().is_empty());
    assert!(open(&path, &listening).unwrap().into_field().unwrap().opacity.is_none());
    assert!(open(&path, &listening).unwrap().into_raster().unwrap().opacity().is_none());
    let [remark] = &listening.remarks()[..] else { panic!("{:?}", listening.remarks()) };
    assert!(remark.contains("leaf.png: its opacity (alpha) is not used"), "{remark}");
}
