//! Polynomial texture maps read by an independent decoder, written from the description of the format alone
//! and sharing nothing with the library: lines of text, blocks of bytes, rows from the bottom, one relit
//! value at a time.

use relume::capture::Capture;
use relume::field::{Basis, PlaneLayout};
use relume::fit::{FitOptions, fit};
use relume::format::{Encoding, FieldFormat, PtmEncoding, decode_field, encode_field, read_raster};
use relume::numeric::random::{Purpose, Stream};
use relume::{Direction, Size, Space};

use crate::support::{data, job, random_field};

/// A texture map parsed by hand.
struct Map {
    version: String,
    format: String,
    width: usize,
    height: usize,
    scale: Vec<f64>,
    bias: Vec<f64>,
    data: Vec<u8>,
}

fn take_apart(file: &[u8]) -> Map {
    let mut rest = file;
    let mut line = || {
        let end = rest.iter().position(|&b| b == b'\n').expect("a line ends");
        let text = String::from_utf8(rest[..end].to_vec()).expect("the header is text");
        rest = &rest[end + 1..];
        text.trim().to_owned()
    };
    let (version, format) = (line(), line());
    let mut sides: Vec<usize> = line().split(' ').map(|n| n.parse().unwrap()).collect();
    if sides.len() == 1 {
        sides.push(line().parse().unwrap());
    }
    let mut numbers = || line().split_whitespace().map(|n| n.parse().unwrap()).collect::<Vec<f64>>();
    let (scale, bias) = (numbers(), numbers());
    assert_eq!((scale.len(), bias.len()), (6, 6));
    Map { version, format, width: sides[0], height: sides[1], scale, bias, data: rest.to_vec() }
}

impl Map {
    /// The value in 0..255 of a channel at (x, y from the top) under the light (u, v).
    fn relit(&self, x: usize, y: usize, channel: usize, u: f64, v: f64) -> f64 {
        let n = self.width * self.height;
        let i = (self.height - 1 - y) * self.width + x;
        let polynomial = |bytes: &[u8]| {
            let a: Vec<f64> = (0..6).map(|k| (f64::from(bytes[k]) - self.bias[k]) * self.scale[k]).collect();
            a[0] * u * u + a[1] * v * v + a[2] * u * v + a[3] * u + a[4] * v + a[5]
        };
        match (self.format.as_str(), self.version.as_str()) {
            ("PTM_FORMAT_RGB", _) => polynomial(&self.data[channel * n * 6 + i * 6..]),
            ("PTM_FORMAT_LRGB", "PTM_1.2") => {
                polynomial(&self.data[i * 6..]) / 255.0 * f64::from(self.data[n * 6 + i * 3 + channel])
            }
            ("PTM_FORMAT_LRGB", _) => {
                polynomial(&self.data[i * 9..]) / 255.0 * f64::from(self.data[i * 9 + 6 + channel])
            }
            (other, _) => panic!("unexpected format {other}"),
        }
    }
}

/// Compares a file, as the library reads it, with the decoder above.
fn assert_read_alike(file: &[u8]) {
    let map = take_apart(file);
    let field = decode_field(file, &job()).unwrap().field;
    assert_eq!((field.size(), field.space()), (Size::new(map.width, map.height), Space::Srgb));
    for (x, y) in (0..map.height).flat_map(|y| (0..map.width).map(move |x| (x, y))) {
        for (u, v) in [(0.0, 0.0), (0.6, -0.3), (-0.2, 0.9), (-0.7, -0.7)] {
            let value = field.value(x, y, Direction::from_disk(u, v));
            for (channel, ours) in value.into_iter().enumerate() {
                let truth = map.relit(x, y, channel, u, v) / 255.0;
                assert!(
                    (f64::from(ours) - truth).abs() < 1e-5 * (1.0 + truth.abs()),
                    "({x}, {y}) channel {channel}: {ours} against {truth}"
                );
            }
        }
    }
}

/// A file of random bytes.
fn made_by_hand(header: &str, payload: usize, seed: u64) -> Vec<u8> {
    let mut random = Stream::new(seed, Purpose::Sample, [0]);
    let mut file = header.as_bytes().to_vec();
    file.extend((0..payload).map(|_| random.below(256) as u8));
    file
}

const NUMBERS: &str = "0.5 1.25 2 3e-1 0.75 1.0\n128 100 -20 127 255 0\n";

#[test]
fn files_made_by_hand_are_read_as_the_format_says() {
    let cases = [
        ("PTM_1.2\nPTM_FORMAT_RGB\n5 3\n", 18),
        ("PTM_1.2\nPTM_FORMAT_RGB\n5\n3\n", 18),
        ("PTM_1.2 \r\nPTM_FORMAT_LRGB\r\n5 \r\n3\r\n", 9),
        ("PTM_1.1\nPTM_FORMAT_LRGB\n5 3\n", 9),
        ("PTM_1.1\nPTM_FORMAT_RGB\n5 3\n", 18),
        ("PTM_1.0\nPTM_FORMAT_LRGB\n5 3\n", 9),
    ];
    for (i, (start, bytes)) in cases.into_iter().enumerate() {
        assert_read_alike(&made_by_hand(&format!("{start}{NUMBERS}"), 15 * bytes, i as u64));
    }
}

#[test]
fn coefficients_that_look_like_white_space_are_kept() {
    for ending in ["\n", " \n", "\r\n"] {
        let mut file =
            format!("PTM_1.2\nPTM_FORMAT_LRGB\n2 1\n1 1 1 1 1 1\n0 0 0 0 0 0{ending}").into_bytes();
        file.extend(b"\n\r \n\n\n\x20\x0a\x0d\x09\n\n\n\n\n   ");
        assert_read_alike(&file);
    }
}

#[test]
fn what_is_written_is_read_by_the_other_decoder() {
    let size = Size::new(7, 5);
    for color in [PlaneLayout::RGB, PlaneLayout::LRGB, PlaneLayout::LUMINANCE] {
        let field = random_field(Basis::Ptm, color.clone(), Space::Srgb, size, 3);
        let file = encode_field(&field, FieldFormat::Ptm, None, &job()).unwrap();
        let map = take_apart(&file);
        assert_eq!((map.version.as_str(), map.width, map.height), ("PTM_1.2", 7, 5));
        assert!(map.bias.iter().all(|b| b.fract() == 0.0));
        assert!(file.windows(5).any(|w| w == b"\n7\n5\n"), "old viewers need two lines for the size");
        assert_read_alike(&file);
        let light = Direction::from_disk(0.3, -0.5);
        for (x, y) in [(0, 0), (6, 0), (0, 4), (3, 2)] {
            for (channel, truth) in field.value(x, y, light).into_iter().enumerate() {
                let found = map.relit(x, y, channel, light.x(), light.y()) / 255.0;
                assert!((found - f64::from(truth)).abs() < 0.02, "{color:?}: {found} against {truth}");
            }
        }
    }
}

#[test]
fn stored_bytes_are_written_as_they_were_read() {
    for (header, bytes) in
        [("PTM_1.2\nPTM_FORMAT_RGB\n16\n16\n", 18), ("PTM_1.2\nPTM_FORMAT_LRGB\n16\n16\n", 9)]
    {
        for numbers in [NUMBERS, "1.7e-3 0.333333 -2 9 2.5 1\n-5000 7 1000000 128 3 -1\n"] {
            let file = made_by_hand(&format!("{header}{numbers}"), 256 * bytes, 9);
            let read = decode_field(&file, &job()).unwrap();
            let again = encode_field(&read.field, FieldFormat::Ptm, Some(&read.encoding), &job()).unwrap();
            let (before, after) = (take_apart(&file), take_apart(&again));
            assert_eq!(before.data, after.data);
            assert_eq!((before.format, before.scale.len()), (after.format, 6));
            for (a, b) in before.scale.iter().chain(&before.bias).zip(after.scale.iter().chain(&after.bias)) {
                assert!((a - b).abs() <= 1e-7 * a.abs());
            }
            assert_eq!(decode_field(&again, &job()).unwrap(), read);
        }
    }
}

#[test]
fn values_beyond_a_given_encoding_are_clamped() {
    let field = random_field(Basis::Ptm, PlaneLayout::RGB, Space::Srgb, Size::new(4, 4), 2);
    let encoding = Encoding::Ptm(PtmEncoding { scale: [0.1; 6], bias: [128.0; 6] });
    let file = encode_field(&field, FieldFormat::Ptm, Some(&encoding), &job()).unwrap();
    let data = take_apart(&file).data;
    assert!(data.contains(&0) && data.contains(&255));
}

#[test]
fn a_fit_of_measured_wool_is_read_by_the_other_decoder() {
    let Some(folder) = data("captures/wool") else { return };
    let capture = Capture::open(&folder).unwrap();
    let load = |i: usize| read_raster(&capture.photographs[i].path, &job());
    for color in [PlaneLayout::RGB, PlaneLayout::LRGB] {
        let options = FitOptions { layout: color.clone(), ..FitOptions::default() };
        let field = fit(&capture.lights(), &load, &options, &job()).unwrap().field;
        let map = take_apart(&encode_field(&field, FieldFormat::Ptm, None, &job()).unwrap());
        let mut squares = 0.0;
        for photograph in &capture.photographs {
            let light = photograph.light;
            for (x, y) in (0..64).map(|i| (i * 37 % 256, i * 101 % 256)) {
                for (channel, truth) in field.value(x, y, light).into_iter().enumerate() {
                    let found = map.relit(x, y, channel, light.x(), light.y()) / 255.0;
                    squares += (found - f64::from(truth)).powi(2);
                }
            }
        }
        let rmse = (squares / (capture.photographs.len() * 64 * 3) as f64).sqrt();
        println!(
            "wool {}: stored in bytes, relit values are off by {:.3} of 255",
            color.name(),
            255.0 * rmse
        );
        assert!(rmse < 1.0 / 255.0, "{color:?}: {rmse}");
    }
}
