//! `relume synth` as a user runs it: every texel is a copy, as the source map proves.

use std::fs::{self, File};
use std::path::Path;
use std::process::Output;

use relume::field::{Basis, PlaneLayout};
use relume::format::{ExrDepth, FieldFormat, encode_field, exr};
use relume::{Job, Planes, ReflectanceField, Size, Space};

use crate::support::{done, failed, read_png};

const EXEMPLAR: (usize, usize) = (37, 29);
const OUTPUT: (usize, usize) = (50, 43);
const BLOCKS: [&str; 6] = ["--size", "50x43", "--block", "12", "--overlap", "3"];

fn synth(folder: &Path, arguments: &[&str]) -> Output {
    let arguments: Vec<&str> = ["synth"].iter().chain(arguments).chain(&BLOCKS).copied().collect();
    done(folder, &arguments)
}

/// Bytes that look like noise, the same each time.
fn bytes(count: usize, seed: u32) -> Vec<u8> {
    let mut state = seed;
    let mut next = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 24) as u8
    };
    (0..count).map(|_| next()).collect()
}

fn write_png(path: &Path, color: png::ColorType, depth: png::BitDepth, samples: &[u8]) {
    let (width, height) = (EXEMPLAR.0 as u32, EXEMPLAR.1 as u32);
    let mut encoder = png::Encoder::new(File::create(path).unwrap(), width, height);
    encoder.set_color(color);
    encoder.set_depth(depth);
    encoder.write_header().unwrap().write_image_data(samples).unwrap();
}

/// x, y and exemplar of the source of each texel, read according to the NumPy format.
fn read_map(path: &Path) -> Vec<[usize; 3]> {
    let file = fs::read(path).unwrap();
    let header = usize::from(u16::from_le_bytes([file[8], file[9]]));
    let text = String::from_utf8_lossy(&file[10..10 + header]);
    assert!(text.contains("'<i4'") && text.contains("(43, 50, 3)"), "{text}");
    let numbers = file[10 + header..].chunks_exact(4).map(|b| i32::from_le_bytes(b.try_into().unwrap()));
    let numbers: Vec<usize> = numbers.map(|n| usize::try_from(n).unwrap()).collect();
    numbers.chunks_exact(3).map(|n| [n[0], n[1], n[2]]).collect()
}

/// Checks that every output texel equals the one named by the map; texels are `length` items each.
fn assert_copies<T: PartialEq + std::fmt::Debug>(map: &[[usize; 3]], from: &[T], to: &[T], length: usize) {
    assert_eq!((map.len(), to.len()), (OUTPUT.0 * OUTPUT.1, OUTPUT.0 * OUTPUT.1 * length));
    for (texel, [x, y, _]) in map.iter().enumerate() {
        let source = y * EXEMPLAR.0 + x;
        assert_eq!(to[texel * length..][..length], from[source * length..][..length], "texel {texel}");
    }
}

#[test]
fn pictures_keep_their_codes_and_registered_images_follow() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let texels = EXEMPLAR.0 * EXEMPLAR.1;
    let (color, grey) = (bytes(texels * 3, 1), bytes(texels * 2, 2));
    write_png(&at("a.png"), png::ColorType::Rgb, png::BitDepth::Eight, &color);
    write_png(&at("height.png"), png::ColorType::Grayscale, png::BitDepth::Sixteen, &grey);
    synth(
        folder.path(),
        &["a.png", "-o", "b.png", "--tile", "--source-map", "map.npy", "--apply", "height.png"],
    );
    let map = read_map(&at("map.npy"));
    let (size, made) = read_png(&at("b.png"));
    assert_eq!(size, OUTPUT);
    assert_copies(&map, &color, &made, 3);
    assert_copies(&map, &grey, &read_png(&at("b_height.png")).1, 2);
    synth(
        folder.path(),
        &["a.png", "-o", "c.png", "--tile", "--source-map", "map.exr", "--apply", "height.png"],
    );
    let (names, planes) = exr::decode_labelled(&fs::read(at("map.exr")).unwrap(), &Job::default()).unwrap();
    assert_eq!(names, ["exemplar", "x", "y"]);
    for (texel, from) in map.iter().enumerate() {
        assert_eq!([1, 2, 0].map(|k| planes.plane(k)[texel] as usize), *from);
    }
}

/// A parsed texture map of luminance and colour: its header, and nine bytes for each texel from the top.
fn take_apart(file: &[u8], (width, height): (usize, usize)) -> (String, Vec<u8>) {
    let texels = width * height;
    let (header, data) = file.split_at(file.len() - 9 * texels);
    let row = |y: usize| (0..width).map(move |x| (height - 1 - y) * width + x);
    let order = (0..height).flat_map(row);
    let bytes = order.flat_map(|i| data[6 * i..][..6].iter().chain(&data[6 * texels + 3 * i..][..3]));
    (String::from_utf8(header.to_vec()).unwrap(), bytes.copied().collect())
}

#[test]
fn texture_maps_keep_their_bytes_scale_and_bias() {
    let folder = tempfile::tempdir().unwrap();
    let mut file = b"PTM_1.2\nPTM_FORMAT_LRGB\n37\n29\n1.5 1 2 1 0.75 1\n128 100 128 120 128 3\n".to_vec();
    file.extend(bytes(EXEMPLAR.0 * EXEMPLAR.1 * 9, 3));
    fs::write(folder.path().join("a.ptm"), &file).unwrap();
    synth(folder.path(), &["a.ptm", "-o", "b.ptm", "--source-map", "map.npy"]);
    let made = fs::read(folder.path().join("b.ptm")).unwrap();
    let ((header, from), (new_header, to)) = (take_apart(&file, EXEMPLAR), take_apart(&made, OUTPUT));
    let numbers = |header: &str| -> Vec<f64> {
        header.split_whitespace().skip(4).map(|n| n.parse().unwrap()).collect()
    };
    assert_eq!(numbers(&header), numbers(&new_header));
    assert_copies(&read_map(&folder.path().join("map.npy")), &from, &to, 9);
}

#[test]
fn exr_fields_keep_their_floats() {
    let folder = tempfile::tempdir().unwrap();
    let size = Size::new(EXEMPLAR.0, EXEMPLAR.1);
    for depth in [ExrDepth::Float, ExrDepth::Half] {
        let values = bytes(size.texels() * 18, 4).into_iter().map(|b| f32::from(b) / 77.0 - 1.0);
        let planes = Planes::from_vec(size, 18, values.collect()).unwrap();
        let field = ReflectanceField::new(Basis::Ptm, PlaneLayout::RGB, Space::Linear, planes).unwrap();
        let file = encode_field(&field, FieldFormat::Exr(depth), None, &Job::default()).unwrap();
        fs::write(folder.path().join("a.exr"), &file).unwrap();
        synth(folder.path(), &["a.exr", "-o", "b.exr", "--source-map", "map.npy", "--force"]);
        let made = fs::read(folder.path().join("b.exr")).unwrap();
        let channels = |file: &[u8]| exr::decode_labelled(file, &Job::default()).unwrap();
        let ((names, from), (new_names, to)) = (channels(&file), channels(&made));
        assert_eq!((names.len(), &names), (18, &new_names));
        let map = read_map(&folder.path().join("map.npy"));
        from.iter().zip(to.iter()).for_each(|(from, to)| assert_copies(&map, from, to, 1));
    }
}

#[test]
fn bytes_are_the_same_at_any_number_of_threads_and_on_standard_output() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let color = bytes(EXEMPLAR.0 * EXEMPLAR.1 * 3, 5);
    write_png(&at("a.png"), png::ColorType::Rgb, png::BitDepth::Eight, &color);
    let mut textures = Vec::new();
    for (blend, feather) in [("cut", "0"), ("graphcut", "0"), ("cut", "2"), ("graphcut", "3"), ("alpha", "0")]
    {
        let make = |output: &str, more: &[&str]| {
            let start = ["a.png", "-o", output, "--force", "--blend", blend, "--feather", feather];
            synth(folder.path(), &[&start, more].concat()).stdout
        };
        make("1.png", &["--threads", "1"]);
        make("5.png", &["--threads", "5"]);
        let one = fs::read(at("1.png")).unwrap();
        assert_eq!(one, fs::read(at("5.png")).unwrap());
        assert_eq!(one, make("-", &[]));
        make("5.png", &["--seed", "1"]);
        assert_ne!(one, fs::read(at("5.png")).unwrap(), "another seed gives another texture");
        assert!(!textures.contains(&one), "--blend {blend} --feather {feather} changes nothing");
        textures.push(one);
    }
    synth(folder.path(), &["a.png", "-o", "1.png", "--force"]);
    assert_eq!(textures[0], fs::read(at("1.png")).unwrap(), "cuts without feathering are the default");
}

#[test]
fn files_and_source_maps_are_the_same_for_every_search() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    for name in ["a.png", "b.png"] {
        let color = bytes(EXEMPLAR.0 * EXEMPLAR.1 * 3, 7 + name.as_bytes()[0] as u32);
        write_png(&at(name), png::ColorType::Rgb, png::BitDepth::Eight, &color);
    }
    let mut mask = vec![0; EXEMPLAR.0 * EXEMPLAR.1];
    mask[5 * EXEMPLAR.0 + 20] = 255;
    write_png(&at("mask.png"), png::ColorType::Grayscale, png::BitDepth::Eight, &mask);
    let inputs = ["a.png", "b.png", "-o", "o.png", "--source-map", "map.npy", "--force"];
    let shared = [&inputs[..], &["--exclude", "mask.png", "mask.png"]].concat();
    for tile in [&[][..], &["--tile"]] {
        let made = |search: &[&str]| {
            synth(folder.path(), &[&shared[..], tile, search].concat());
            [fs::read(at("o.png")).unwrap(), fs::read(at("map.npy")).unwrap()]
        };
        let truth = made(&["--search", "brute"]);
        for search in ["auto", "fft", "projection"] {
            assert_eq!(made(&["--search", search]), truth, "{search} {tile:?}");
        }
        for kernels in ["dct", "walsh-hadamard"] {
            assert_eq!(made(&["--search", "projection", "--kernels", kernels]), truth, "{kernels} {tile:?}");
        }
    }
}

#[test]
fn what_cannot_be_done_is_said_and_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let texels = EXEMPLAR.0 * EXEMPLAR.1;
    write_png(&at("a.png"), png::ColorType::Rgb, png::BitDepth::Eight, &bytes(texels * 3, 6));
    write_png(&at("grey.png"), png::ColorType::Grayscale, png::BitDepth::Eight, &bytes(texels, 7));
    let mut encoder = png::Encoder::new(File::create(at("small.png")).unwrap(), 4, 4);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.write_header().unwrap().write_image_data(&[9; 16]).unwrap();
    let failed_with = |arguments: &[&str], status| {
        let all: Vec<&str> = ["synth", "a.png", "-o", "b.png"].iter().chain(arguments).copied().collect();
        failed(folder.path(), &all, status)
    };
    let refused = |arguments: &[&str]| failed_with(arguments, 2);
    let text = refused(&["--size", "64", "--block", "30"]);
    assert!(text.contains("37 x 29") && text.contains("at most 29"), "{text}");
    assert!(refused(&["--size", "20", "--block", "24", "--tile"]).contains("20 x 20"));
    assert!(refused(&["--size", "64", "--block", "12", "--overlap", "7"]).contains("1 to 6"));
    let text = failed_with(&["--size", "64", "--block", "8", "--apply", "small.png"], 1);
    assert!(text.contains("small.png") && text.contains("4 x 4") && text.contains("37 x 29"), "{text}");
    assert!(refused(&["grey.png", "--size", "64", "--block", "8"]).contains("one kind"));
    assert!(refused(&["--size", "64", "--source-map", "map.txt"]).contains("map.txt"));
    assert!(refused(&["--size", "64", "--source-map", "b.png"]).contains("two outputs"));
    assert!(refused(&["--size", "64", "--block", "8", "--tolerance", "nan"]).contains("--tolerance"));
    let text = refused(&["--size", "64", "--block", "12", "--overlap", "3", "--feather", "4"]);
    assert!(text.contains("0 to 3"), "{text}");
    let text = refused(&["--size", "64", "--block", "8", "--blend", "alpha", "--feather", "1"]);
    assert!(text.contains("cut or graphcut"), "{text}");
    refused(&["--size", "64", "--block", "8", "--metric", "legendre9"]);
}
