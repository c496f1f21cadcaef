//! Broken and hostile files give one sentence, never a panic, and never allocate the memory they merely claim
//! to need.

use std::panic::catch_unwind;
use std::path::Path;
use std::sync::Arc;

use relume::capture::lp;
use relume::direction::{Direction, Directions};
use relume::field::{Basis, PlaneLayout};
use relume::format::bonn::BonnBtf;
use relume::format::exr::encode_labelled;
use relume::format::{
    Depth, ExrDepth, FieldFormat, HeightFormat, NormalY, PictureFormat, decode_brdf, decode_field,
    decode_height, decode_mask, decode_mesh, decode_normals, decode_raster, encode_field, encode_height,
    encode_normals, encode_picture, npy, rlm,
};
use relume::numeric::random::{Purpose, Stream};
use relume::{Error, ErrorKind, Job, Limits, Picture, Planes, Size, Space};

use crate::brdf_files::small_rgl_files;
use crate::btf_files::small_btf_files;
use crate::support::{job, random_field};

/// A small valid file of every kind that is read.
fn small_files() -> Vec<(String, Vec<u8>)> {
    let size = Size::new(9, 6);
    let mut files = Vec::new();
    for color in [PlaneLayout::RGB, PlaneLayout::LRGB] {
        let field = random_field(Basis::Ptm, color.clone(), Space::Srgb, size, 1);
        for format in [
            FieldFormat::Ptm,
            FieldFormat::PtmJpeg { quality: 90 },
            FieldFormat::Exr(ExrDepth::Half),
            FieldFormat::Exr(ExrDepth::Float),
        ] {
            let name = format!("{color:?} {format:?}");
            files.push((name, encode_field(&field, format, None, &job()).unwrap()));
        }
    }
    for color in [PlaneLayout::RGB, PlaneLayout::LRGB] {
        let harmonics = Basis::from_name("hsh9").unwrap();
        let field = random_field(harmonics, color.clone(), Space::Srgb, size, 1);
        for format in [FieldFormat::Rti, FieldFormat::Hsh] {
            let name = format!("{color:?} {format:?}");
            files.push((name, encode_field(&field, format, None, &job()).unwrap()));
        }
    }
    let formats = [
        PictureFormat::Png(Depth::Eight),
        PictureFormat::Png(Depth::Sixteen),
        PictureFormat::Tiff(Depth::Eight),
        PictureFormat::Tiff(Depth::Sixteen),
        PictureFormat::Jpeg { quality: 90 },
        PictureFormat::Exr(ExrDepth::Float),
        PictureFormat::Pfm,
        PictureFormat::Radiance,
    ];
    for channels in [1, 3] {
        let mut random = Stream::new(2, Purpose::Sample, [channels as u64]);
        let values = (0..size.texels() * channels).map(|_| random.unit() as f32).collect();
        let picture =
            Picture { planes: Planes::from_vec(size, channels, values).unwrap(), space: Space::Srgb };
        for format in formats {
            files.push((format!("{channels} {format:?}"), encode_picture(&picture, format).unwrap()));
        }
    }
    files
}

/// A small valid file of every kind that depends on light and view. Those of MERL and UTIA have one size only, of
/// megabytes: `measured_brdf.rs` breaks them.
fn small_measured_files() -> Vec<(String, Vec<u8>)> {
    let btf = small_btf_files().into_iter().map(|(name, file)| (name, file.bytes));
    btf.chain(small_rgl_files()).collect()
}

/// Reads a texture of light and view with all its images, or a reflectance with a value.
fn read_measured(bytes: &[u8]) -> Result<(), Error> {
    if bytes.starts_with(b"tensor") {
        let brdf = decode_brdf(bytes, &job())?;
        brdf.evaluate(Directions::lit_from(Direction::from_angles(0.5, 1.0)));
        return Ok(());
    }
    let btf = BonnBtf::decode(Arc::new(bytes.to_vec()), &job())?;
    (0..btf.pairs().len().min(50)).try_for_each(|i| btf.planes(i, &job()).map(drop))
}

/// Every reader on the same bytes; whether it could read them.
fn read(bytes: &[u8]) -> [Result<(), Error>; 2] {
    [decode_field(bytes, &job()).map(drop), decode_raster(bytes, &job()).map(drop)]
}

fn assert_one_sentence(error: &Error) {
    let message = error.message();
    assert!(!message.is_empty() && message.len() < 500 && !message.contains('\n'), "{message}");
}

#[test]
fn a_file_cut_at_any_byte_is_an_error() {
    for (name, file) in small_files() {
        assert!(decode_field(&file, &job()).is_ok(), "{name}");
        for length in 0..file.len() {
            for result in read(&file[..length]) {
                let error = result.expect_err(&format!("{name} cut to {length} of {} bytes", file.len()));
                assert_one_sentence(&error);
            }
        }
    }
}

/// Changed files of each format.
const CHANGED: usize = 10_000;

/// A file with up to five bytes changed, half of them in the head, which holds the structure. Bytes of `words` stand for those
/// that texts consist of.
fn changed(file: &[u8], words: &[u8], random: &mut Stream) -> Vec<u8> {
    let mut changed = file.to_vec();
    for _ in 0..=random.below(4) {
        let reach = if random.below(2) == 0 { file.len().min(400) } else { file.len() };
        let at = random.below(reach);
        changed[at] = match random.below(3) {
            0 => changed[at] ^ (1 << random.below(8)),
            1 => words[random.below(words.len())],
            _ => random.below(256) as u8,
        };
    }
    changed
}

/// Gives changed files to a reader: [`CHANGED`] of each format, divided among the files of that.
fn assert_never_panics(
    files: &[(String, Vec<u8>)],
    format: impl Fn(&str) -> String,
    words: &[u8],
    read: impl Fn(&[u8]) -> Vec<Result<(), Error>> + std::panic::RefUnwindSafe,
) {
    let mut random = Stream::new(77, Purpose::Sample, [files.len() as u64]);
    for (name, file) in files {
        let alike = files.iter().filter(|(other, _)| format(other) == format(name)).count();
        for round in 0..CHANGED.div_ceil(alike) {
            let changed = changed(file, words, &mut random);
            let results = catch_unwind(|| read(&changed)).unwrap_or_else(|_| panic!("{name}, round {round}"));
            results.iter().filter_map(|result| result.as_ref().err()).for_each(assert_one_sentence);
        }
    }
}

const EXTREMES: [u8; 4] = [0, 0xff, 0x7f, 0x80];

#[test]
fn changed_bytes_never_panic() {
    let format = |name: &str| {
        let words = name.split(|c: char| !c.is_ascii_alphabetic());
        let known = ["PtmJpeg", "Ptm", "Exr", "Rti", "Hsh", "Png", "Tiff", "Jpeg", "Pfm", "Radiance"];
        words.into_iter().find(|word| known.contains(word)).unwrap_or("other").to_owned()
    };
    assert_never_panics(&small_files(), format, &EXTREMES, |bytes| read(bytes).to_vec());
}

#[test]
fn changed_textures_of_functions_never_panic() {
    let of_functions =
        |name: &str| ["PtmJpeg", "Rti", "Hsh"].into_iter().find(|format| name.contains(format));
    let files: Vec<_> = small_files().into_iter().filter(|(name, _)| of_functions(name).is_some()).collect();
    assert_eq!(files.len(), 6);
    let format = |name: &str| of_functions(name).unwrap_or_default().to_owned();
    assert_never_panics(&files, format, b"0129 -.\n", |bytes| vec![decode_field(bytes, &job()).map(drop)]);
}

/// A triangle in binary glTF.
fn small_glb() -> Vec<u8> {
    let points: [f32; 9] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    let mut data: Vec<u8> = points.iter().flat_map(|v| v.to_le_bytes()).collect();
    data.extend([0, 0, 1, 0, 2, 0, 0, 0]);
    data.extend([0.0f32, 0.0, 1.0, 0.0, 0.0, 1.0].iter().flat_map(|v| v.to_le_bytes()));
    let mut text = br#"{"asset":{"version":"2.0"},"buffers":[{"byteLength":68}],"bufferViews":[{"buffer":0,"byteLength":36},
        {"buffer":0,"byteOffset":36,"byteLength":6},{"buffer":0,"byteOffset":44,"byteLength":24}],"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3",
        "min":[0,0,0],"max":[1,1,0]},{"bufferView":1,"componentType":5123,"count":3,"type":"SCALAR"},{"bufferView":2,"componentType":5126,"count":3,"type":"VEC2"}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0,"TEXCOORD_0":2},"indices":1}]}],"nodes":[{"mesh":0}],"scenes":[{"nodes":[0]}],
        "scene":0}"#
        .to_vec();
    text.resize(text.len().next_multiple_of(4), b' ');
    let chunk =
        |kind: &[u8; 4], bytes: &[u8]| [&(bytes.len() as u32).to_le_bytes(), &kind[..], bytes].concat();
    let body = [chunk(b"JSON", &text), chunk(b"BIN\0", &data)].concat();
    [b"glTF", &2u32.to_le_bytes()[..], &(body.len() as u32 + 12).to_le_bytes(), &body].concat()
}

#[test]
fn changed_meshes_arrays_and_light_files_never_panic() {
    let glb = small_glb();
    decode_mesh(&glb, &job()).unwrap();
    let obj = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nvn 0 0 1\nf 1/1/1 2/2/1 4/3/1 3/1/1\nf -1/-1 -2/-2 -3/-3\n";
    decode_mesh(obj, &job()).unwrap();
    let meshes = [("glb".to_owned(), glb), ("obj".to_owned(), obj.to_vec())];
    let words = b"0129 -./\n\"{}[]:,";
    assert_never_panics(&meshes, str::to_owned, words, |bytes| vec![decode_mesh(bytes, &job()).map(drop)]);
    let arrays = [("npy".to_owned(), npy::encode_i32(Size::new(3, 2), 2, &[7; 12]).unwrap())];
    assert_never_panics(&arrays, str::to_owned, words, |bytes| {
        vec![npy::decode_i32(bytes, &job()).map(drop)]
    });
    let lights = b"2\na photograph.jpg 0.1 0.2 0.97\nC:\\b.jpg 0,5 0 0,866\n".to_vec();
    lp::parse(&lights).unwrap();
    let lights = [("lp".to_owned(), lights)];
    assert_never_panics(&lights, str::to_owned, b"0129 -.,\n", |bytes| vec![lp::parse(bytes).map(drop)]);
}

#[test]
fn changed_maps_never_panic() {
    let size = Size::new(9, 6);
    let planes = |count: usize| {
        let values = (0..count * size.texels()).map(|i| 0.5 + 0.4 * (0.7 * i as f32).sin()).collect();
        Planes::from_vec(size, count, values).unwrap()
    };
    let heights = [HeightFormat::Png, HeightFormat::Exr]
        .map(|format| (format!("{format:?}"), encode_height(&planes(1), Some(0.1), format).unwrap()));
    let read_heights = |bytes: &[u8]| vec![decode_height(bytes, &job()).map(drop)];
    assert_never_panics(&heights, |_| String::new(), b"0129e-. ", read_heights);
    let png = PictureFormat::Png(Depth::Sixteen);
    let normals = [("normals".to_owned(), encode_normals(&planes(3), NormalY::Down, png, &job()).unwrap())];
    assert_never_panics(&normals, str::to_owned, &EXTREMES, |bytes| {
        vec![
            decode_normals(bytes, Path::new("n.png"), None, &job()).map(drop),
            decode_mask(bytes, &job()).map(drop),
        ]
    });
}

#[test]
fn measured_files_cut_at_any_byte_are_errors() {
    for (name, file) in small_measured_files() {
        read_measured(&file).unwrap_or_else(|e| panic!("{name}: {e}"));
        for length in 0..file.len() {
            let error = read_measured(&file[..length]).expect_err(&format!("{name} cut to {length}"));
            assert_one_sentence(&error);
        }
    }
}

#[test]
fn changed_bytes_of_measured_files_never_panic() {
    let format = |name: &str| name.split_whitespace().next().unwrap_or_default().to_owned();
    assert_never_panics(&small_measured_files(), format, &EXTREMES, |bytes| vec![read_measured(bytes)]);
}

fn map_error(header: &str, payload: usize) -> Error {
    let mut file = header.as_bytes().to_vec();
    file.resize(file.len() + payload, 7);
    decode_field(&file, &Job::default()).unwrap_err()
}

#[test]
fn broken_texture_maps_say_what_and_where() {
    let ones = "1 1 1 1 1 1\n0 0 0 0 0 0\n";
    let start = "PTM_1.2\nPTM_FORMAT_RGB\n";
    let cases = [
        ("PTM_2.0\nPTM_FORMAT_RGB\n1 1\n".to_owned() + ones, 18, "PTM_2.0"),
        (format!("PTM_1.2\nPTM_FORMAT_HSV\n1 1\n{ones}"), 18, "PTM_FORMAT_HSV"),
        (format!("PTM_1.2\nwhatever\n1 1\n{ones}"), 18, "whatever"),
        (format!("{start}0 4\n{ones}"), 0, "the width of the texture map, at byte 23, is '0'"),
        (format!("{start}4 -4\n{ones}"), 0, "the height of the texture map, at byte 25, is '-4'"),
        (format!("{start}1000000000 1000000000\n{ones}"), 18, "truncated"),
        (format!("{start}18446744073709551615 18446744073709551615\n{ones}"), 18, "truncated"),
        (format!("{start}99999999999999999999 1\n{ones}"), 18, "whole number"),
        (
            format!("{start}2 1\n{ones}"),
            35,
            "2 x 1 texels need 36 bytes of coefficients from byte 51 on, found 35",
        ),
        (format!("{start}2 1\n{ones}"), 37, "does not match the coefficients"),
        (
            format!("{start}1 1\n1 1 nan 1 1 1\n0 0 0 0 0 0\n"),
            18,
            "scale 3 of 6 of the texture map, at byte 31",
        ),
        (format!("{start}1 1\n1 0 1 1 1 1\n0 0 0 0 0 0\n"), 18, "zero"),
        (format!("{start}1 1\n1 1 1 1 1 inf\n0 0 0 0 0 0\n"), 18, "scale 6"),
        (format!("{start}1 1\n1 1 1 1 1 1\n0 0 0 0 0 x\n"), 18, "bias 6"),
        (format!("{start}1 1\n1 1 1 1 1 1\n0 0 0 0 0 1e9\n"), 18, "bias 6"),
        (format!("{start}1 1\n1 1 1 1 1 1\n0 0 0 0 0 0 0\n"), 18, "no end of line at byte 51"),
        (format!("{start}{}", "7".repeat(100)), 0, "the width"),
    ];
    for (header, payload, expected) in cases {
        let error = map_error(&header, payload);
        assert_one_sentence(&error);
        assert!(error.message().contains(expected), "{header:?}: {error}");
    }
}

#[test]
fn other_kinds_of_texture_maps_are_refused_by_name() {
    let kinds = [
        "PTM_FORMAT_PTM_LUT",
        "PTM_FORMAT_PTM_C_LUT",
        "PTM_FORMAT_JPEGLS_RGB",
        "PTM_FORMAT_JPEGLS_LRGB",
        "PTM_C_LUT",
        "JPEGLS_RGB",
    ];
    for kind in kinds {
        let error = map_error(&format!("PTM_1.2\n{kind}\n1 1\n1 1 1 1 1 1\n0 0 0 0 0 0\n"), 99);
        assert_eq!(error.kind(), ErrorKind::Unsupported);
        assert!(error.message().contains(kind), "{error}");
    }
}

#[test]
fn sizes_are_refused_before_memory_is_taken() {
    let tight = Job::new(Limits { max_bytes: 1 << 20, max_side: 300 });
    let wide = Picture { planes: Planes::zeros(Size::new(301, 1), 3), space: Space::Srgb };
    let large = Picture { planes: Planes::zeros(Size::new(299, 299), 3), space: Space::Srgb };
    let formats = [
        PictureFormat::Png(Depth::Eight),
        PictureFormat::Tiff(Depth::Eight),
        PictureFormat::Jpeg { quality: 90 },
        PictureFormat::Exr(ExrDepth::Half),
    ];
    for format in formats {
        for picture in [&wide, &large] {
            let file = encode_picture(picture, format).unwrap();
            let error = decode_field(&file, &tight).unwrap_err();
            assert_eq!(error.kind(), ErrorKind::Limit, "{format:?}: {error}");
        }
    }
    // A PNG header that claims 65,535 x 65,535 texels.
    let mut bomb = encode_picture(&wide, PictureFormat::Png(Depth::Eight)).unwrap();
    bomb[16..24].copy_from_slice(&[0, 0, 0xff, 0xff, 0, 0, 0xff, 0xff]);
    let crc = crc32(&bomb[12..29]).to_be_bytes();
    bomb[29..33].copy_from_slice(&crc);
    assert_eq!(decode_raster(&bomb, &Job::default()).unwrap_err().kind(), ErrorKind::Invalid);
}

/// The checksum of PNG chunks, bit by bit.
fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0u32, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |c, _| if c & 1 == 1 { (c >> 1) ^ 0xedb8_8320 } else { c >> 1 })
    })
}

#[test]
fn exr_files_without_a_picture_say_what_they_hold() {
    let planes = Planes::zeros(Size::new(4, 4), 2);
    let file = encode_labelled(&["depth", "mask"], &planes, ExrDepth::Float).unwrap();
    let error = decode_raster(&file, &job()).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Unsupported);
    assert!(error.message().contains("depth, mask"), "{error}");
    let listening = job();
    let field = decode_field(&file, &listening).unwrap().field;
    assert_eq!(field.layout().channel_names(), ["depth", "mask"]);
    assert!(listening.remarks()[0].contains("depth, mask"), "{:?}", listening.remarks());
    let field = random_field(Basis::Ptm, PlaneLayout::RGB, Space::Linear, Size::new(4, 4), 1);
    let file = encode_field(&field, FieldFormat::Exr(ExrDepth::Float), None, &job()).unwrap();
    assert!(decode_raster(&file, &job()).unwrap_err().message().contains("relight"));
}

/// A progressive or baseline JPEG of so many texels whose scan is all but empty.
fn jpeg_bomb(frame: u8, side: u16, components: u8) -> Vec<u8> {
    let size = side.to_be_bytes();
    let length = (8 + 3 * u16::from(components)).to_be_bytes();
    let mut file = vec![0xff, 0xd8, 0xff, frame, length[0], length[1], 8];
    file.extend([size[0], size[1], size[0], size[1], components]);
    (1..=components).for_each(|id| file.extend([id, 0x11, 0]));
    file.extend([0xff, 0xda, 0, 6 + 2 * components, components]);
    (1..=components).for_each(|id| file.extend([id, 0]));
    file.extend([0, 63, 0, 0x55, 0xff, 0xd9]);
    file
}

#[test]
fn small_files_that_claim_gigabytes_are_refused_by_their_headers() {
    let generous = Job::new(Limits { max_bytes: 1 << 40, max_side: 1 << 17 });
    let mut bombs: Vec<Vec<u8>> = [(0xc0, 1), (0xc0, 3), (0xc2, 1), (0xc2, 3)]
        .map(|(frame, components)| jpeg_bomb(frame, 65_000, components))
        .to_vec();
    let small = Picture { planes: Planes::zeros(Size::new(3, 3), 3), space: Space::Srgb };
    let mut png = encode_picture(&small, PictureFormat::Png(Depth::Eight)).unwrap();
    png[16..24].copy_from_slice(&[0, 0, 0xff, 0xff, 0, 0, 0xff, 0xff]);
    let crc = crc32(&png[12..29]).to_be_bytes();
    png[29..33].copy_from_slice(&crc);
    bombs.push(png);
    for bomb in bombs {
        let error = decode_raster(&bomb, &generous).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::Invalid, "{error}");
        assert!(error.message().contains("cannot hold so many"), "{error}");
    }
}

/// A model file of version 1 around the bits of a model.
fn model_file(body: &[u8]) -> Vec<u8> {
    let length = (body.len() as u32).to_le_bytes();
    let sum = crc32(&[&length, body].concat()).to_le_bytes();
    [b"RLM\x1a\x01", &sum[..], &length, body].concat()
}

#[test]
fn a_model_that_claims_more_than_its_file_or_the_memory_holds_is_refused() {
    let mut announced = model_file(&[0; 8]);
    announced[9..13].copy_from_slice(&u32::MAX.to_le_bytes());
    let error = rlm::decode(&announced, &job()).unwrap_err();
    assert!(error.message().contains("announces 4294967295 bytes, but 8 follow"), "{error}");
    // 65,535 planes with a component each have two thousand million weights.
    let names = [b"\x08constant", &b"\x09luminance"[..], b"\x06linear", &[0; 16]].concat();
    let model = [&names[..], &[0xff, 0xff, 2, 1], &[0xff; 8192]].concat();
    let tight = Job::new(Limits { max_bytes: 1 << 20, ..Limits::default() });
    let error = rlm::decode(&model_file(&model), &tight).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Limit, "{error}");
}

#[test]
fn values_that_are_not_finite_are_found_with_their_channel_and_texel() {
    for (value, word) in [(f32::NAN, "NaN"), (f32::INFINITY, "infinite"), (f32::NEG_INFINITY, "infinite")] {
        let mut planes = Planes::zeros(Size::new(5, 4), 3);
        planes.plane_mut(1)[2 * 5 + 3] = value;
        let picture = Picture { planes, space: Space::Linear };
        for depth in [ExrDepth::Half, ExrDepth::Float] {
            let file = encode_picture(&picture, PictureFormat::Exr(depth)).unwrap();
            for result in read(&file) {
                let message = result.unwrap_err().message().to_owned();
                let expected = format!("channel 'G' is {word} at texel (3, 2)");
                assert!(message.contains(&expected), "{message}");
            }
        }
    }
}

#[test]
fn messages_never_show_a_decoders_own_words() {
    const INNER: [&str; 8] =
        ["DecoderError", "ImageError", "Format error", "exr::", "Some(", "{ ", "ColorType", "Error("];
    let mut random = Stream::new(78, Purpose::Sample, [0]);
    for (name, file) in small_files() {
        for _ in 0..300 {
            let mut changed = file.clone();
            for _ in 0..=random.below(3) {
                let at = random.below(file.len().min(400));
                changed[at] = random.below(256) as u8;
            }
            for error in read(&changed).into_iter().filter_map(Result::err) {
                let shown = INNER.iter().find(|word| error.message().contains(**word));
                assert_eq!(shown, None, "{name}: {error}");
            }
        }
    }
}
