//! Files of harmonics read by an independent decoder and written by an independent writer, both from the description
//! of the formats alone: text and bytes by hand, the nine functions by their formulas with the azimuth.

use std::f64::consts::PI;

use relume::field::{Basis, PlaneLayout};
use relume::format::{Content, FieldFormat, decode_field, encode_field, open};
use relume::numeric::random::{Purpose, Stream};
use relume::{Direction, ErrorKind, Size, Space};

use crate::support::{job, random_field};

/// The functions in their order, as decoders have them.
fn functions(light: Direction) -> [f64; 9] {
    let p = light.y().atan2(light.x());
    let c = light.z();
    let s = (c - c * c).sqrt();
    [
        1.0 / (2.0 * PI).sqrt(),
        (6.0 / PI).sqrt() * p.cos() * s,
        (3.0 / (2.0 * PI)).sqrt() * (2.0 * c - 1.0),
        (6.0 / PI).sqrt() * p.sin() * s,
        (30.0 / PI).sqrt() * (2.0 * p).cos() * (c * c - c),
        (30.0 / PI).sqrt() * p.cos() * (2.0 * c - 1.0) * s,
        (5.0 / (2.0 * PI)).sqrt() * (1.0 - 6.0 * c + 6.0 * c * c),
        (30.0 / PI).sqrt() * (2.0 * c - 1.0) * s * p.sin(),
        (30.0 / PI).sqrt() * (c * c - c) * (2.0 * p).sin(),
    ]
}

/// A file taken apart by hand.
struct ByHand {
    size: Size,
    terms: usize,
    is_product: bool,
    /// The range and the least value of each term.
    scale: Vec<f64>,
    bias: Vec<f64>,
    texels: Vec<u8>,
}

fn floats(bytes: &[u8]) -> Vec<f64> {
    bytes.chunks(4).map(|b| f64::from(f32::from_le_bytes(b.try_into().unwrap()))).collect()
}

fn rti(file: &[u8]) -> ByHand {
    let mut rest = file;
    let mut lines = Vec::new();
    while lines.len() < 3 {
        let end = rest.iter().position(|&b| b == b'\n').unwrap();
        let line = String::from_utf8(rest[..end].to_vec()).unwrap();
        rest = &rest[end + 1..];
        if !line.starts_with('#') {
            lines.push(line.split_whitespace().map(|w| w.parse().unwrap()).collect::<Vec<usize>>());
        }
    }
    assert_eq!((lines[0][0], lines[1][2], lines[2][2]), (3, 3, 1));
    let terms = lines[2][0];
    ByHand {
        size: Size::new(lines[1][0], lines[1][1]),
        terms,
        is_product: lines[2][1] == 1,
        scale: floats(&rest[..4 * terms]),
        bias: floats(&rest[4 * terms..8 * terms]),
        texels: rest[8 * terms..].to_vec(),
    }
}

fn hsh(file: &[u8]) -> ByHand {
    let integer = |k: usize| u32::from_le_bytes(file[4 * k..4 * k + 4].try_into().unwrap()) as usize;
    assert_eq!(integer(2), 3);
    let terms = integer(3) * integer(3);
    let low = floats(&file[16..16 + 4 * terms]);
    let high = floats(&file[16 + 4 * terms..16 + 8 * terms]);
    ByHand {
        size: Size::new(integer(0), integer(1)),
        terms,
        is_product: false,
        scale: high.iter().zip(&low).map(|(h, l)| h - l).collect(),
        bias: low,
        texels: file[16 + 8 * terms..].to_vec(),
    }
}

impl ByHand {
    fn relit(&self, x: usize, y: usize, channel: usize, light: Direction) -> f64 {
        let texel = y * self.size.width + x;
        let value =
            |at: usize, k: usize| f64::from(self.texels[at + k]) / 255.0 * self.scale[k] + self.bias[k];
        let sum = |at: usize| (0..self.terms).map(|k| value(at, k) * functions(light)[k]).sum::<f64>();
        match self.is_product {
            true => {
                let at = texel * (self.terms + 3);
                sum(at) * f64::from(self.texels[at + self.terms + channel]) / 255.0
            }
            false => sum((3 * texel + channel) * self.terms),
        }
    }
}

fn lights() -> [Direction; 4] {
    [[0.1, 0.2], [0.7, -0.3], [-0.5, 0.6], [-0.6, -0.6]].map(|[u, v]| Direction::from_disk(u, v))
}

fn assert_read_alike(file: &[u8], map: &ByHand) {
    let field = decode_field(file, &job()).unwrap().field;
    assert_eq!((field.size(), field.space(), field.basis().len()), (map.size, Space::Srgb, map.terms));
    let places = (0..map.size.height).flat_map(|y| (0..map.size.width).map(move |x| (x, y)));
    for ((x, y), light) in places.flat_map(|at| lights().map(|light| (at, light))) {
        for (channel, ours) in field.value(x, y, light).into_iter().enumerate() {
            let truth = map.relit(x, y, channel, light);
            assert!(
                (f64::from(ours) - truth).abs() < 1e-5 * (1.0 + truth.abs()),
                "({x}, {y}): {ours}, {truth}"
            );
        }
    }
}

fn noise(length: usize, seed: u64) -> Vec<u8> {
    let mut random = Stream::new(seed, Purpose::Sample, [0]);
    (0..length).map(|_| random.below(256) as u8).collect()
}

fn scales(terms: usize) -> Vec<u8> {
    let scale = (0..terms).map(|k| 0.3 + 0.1 * k as f32);
    let bias = (0..terms).map(|k| -0.2 + 0.05 * k as f32);
    scale.chain(bias).flat_map(f32::to_le_bytes).collect()
}

#[test]
fn files_made_by_hand_are_read_as_the_format_says() {
    let heads = [
        ("#HSH1.2\n3\n5 4 3\n9 2 1\n", 27),
        ("#HSH1.2\r\n# made by hand\r\n3\r\n5 4 3\r\n9 2 1\r\n", 27),
        ("#HSH1.2\n3\n5 4 3\n9 1 1\n", 12),
    ];
    for (i, (head, texel)) in heads.into_iter().enumerate() {
        let file = [head.as_bytes(), &scales(9), &noise(20 * texel, i as u64)].concat();
        assert_read_alike(&file, &rti(&file));
    }
}

#[test]
fn an_order_where_the_number_of_terms_is_meant_is_told_by_the_length() {
    let whole = [&b"#HSH1.2\n3\n5 4 3\n9 2 1\n"[..], &scales(9), &noise(20 * 27, 3)].concat();
    let order = [&b"#HSH1.2\n3\n5 4 3\n2 2 1\n"[..], &whole[22..]].concat();
    assert_eq!(decode_field(&order, &job()).unwrap(), decode_field(&whole, &job()).unwrap());
}

#[test]
fn old_files_are_read_with_and_without_comments() {
    let head: Vec<u8> = [5u32, 4, 3, 3].into_iter().flat_map(u32::to_le_bytes).collect();
    let old = [&head[..], &scales(9), &noise(20 * 27, 4)].concat();
    assert_read_alike(&old, &hsh(&old));
    let commented = [b"# an old file\n", &old[..]].concat();
    assert_eq!(decode_field(&commented, &job()).unwrap(), decode_field(&old, &job()).unwrap());
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in [("old", &old), ("commented", &commented)] {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        assert_eq!(open(&path, &job()).unwrap().content(), Content::Field, "{name}");
    }
}

#[test]
fn what_is_written_is_read_by_the_other_decoder_and_alike() {
    let size = Size::new(7, 5);
    for layout in [PlaneLayout::RGB, PlaneLayout::LRGB, PlaneLayout::LUMINANCE] {
        let field = random_field(Basis::from_name("hsh9").unwrap(), layout.clone(), Space::Srgb, size, 3);
        for format in [FieldFormat::Rti, FieldFormat::Hsh] {
            let file = encode_field(&field, format, None, &job()).unwrap();
            let map = if format == FieldFormat::Rti { rti(&file) } else { hsh(&file) };
            assert_eq!(map.is_product, format == FieldFormat::Rti && layout == PlaneLayout::LRGB);
            assert_read_alike(&file, &map);
            for (x, y, light) in [(0, 0, 0), (6, 0, 1), (0, 4, 2), (3, 2, 3)] {
                let light = lights()[light];
                for (channel, truth) in field.value(x, y, light).into_iter().enumerate() {
                    let found = map.relit(x, y, channel, light);
                    assert!((found - f64::from(truth)).abs() < 0.03, "{layout:?}: {found} against {truth}");
                }
            }
        }
    }
}

#[test]
fn stored_bytes_of_harmonics_are_written_as_they_were_read() {
    for (kind, texel) in [(2, 27), (1, 12)] {
        let head = format!("#HSH1.2\n3\n16 16 3\n9 {kind} 1\n");
        let file = [head.as_bytes(), &scales(9), &noise(256 * texel, 9)].concat();
        let read = decode_field(&file, &job()).unwrap();
        let again = encode_field(&read.field, FieldFormat::Rti, Some(&read.encoding), &job()).unwrap();
        assert!(again == file, "kind {kind}");
    }
}

#[test]
fn other_kinds_of_harmonics_are_refused_by_name() {
    let refused = |head: &str| {
        let file = [head.as_bytes(), &scales(9), &noise(20 * 27, 3)].concat();
        decode_field(&file, &job()).unwrap_err()
    };
    for (head, word) in [
        ("#HSH1.2\n1\n5 4 3\n9 2 1\n", "polynomials"),
        ("#HSH1.2\n2\n5 4 3\n9 2 1\n", "spherical"),
        ("#HSH1.2\n4\n5 4 3\n9 2 1\n", "adaptive"),
        ("#HSH1.2\n3\n5 4 3\n9 2 4\n", "4 bytes a number"),
        ("#HSH1.2\n3\n5 4 3\n9 7 1\n", "kind 7"),
        ("#HSH1.2\n3\n5 4 3\n11 2 1\n", "11 terms"),
    ] {
        let error = refused(head);
        assert_eq!(error.kind(), ErrorKind::Unsupported, "{error}");
        assert!(error.message().contains(word), "{error}");
    }
    assert!(refused("#HSH1.2\n3\n5 5 3\n9 2 1\n").message().contains("truncated"));
    let ptm = random_field(Basis::Ptm, PlaneLayout::RGB, Space::Srgb, Size::new(3, 3), 1);
    let error = encode_field(&ptm, FieldFormat::Rti, None, &job()).unwrap_err();
    assert!(error.message().contains("relume convert"), "{error}");
    let linear =
        random_field(Basis::from_name("hsh9").unwrap(), PlaneLayout::RGB, Space::Linear, Size::new(3, 3), 1);
    assert!(encode_field(&linear, FieldFormat::Hsh, None, &job()).unwrap_err().message().contains("linear"));
}
