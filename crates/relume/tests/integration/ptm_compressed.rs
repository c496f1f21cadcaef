//! Compressed and `LUM` texture maps, against a decoder written from the description of the format alone, with a
//! JPEG decoder other than the library's settings: planes first, predictions by the formulas, rows from the bottom.

use relume::field::{Basis, PlaneLayout};
use relume::format::{FieldFormat, decode_field, encode_field};
use relume::numeric::random::{Purpose, Stream};
use relume::{Direction, ErrorKind, Planes, ReflectanceField, Size, Space};

use crate::support::{data, job, random_field};

/// The header of a file, word by word, and the bytes after it.
struct Parsed {
    words: Vec<String>,
    payload: Vec<u8>,
}

impl Parsed {
    fn of(file: &[u8], lines: usize) -> Self {
        let mut rest = file;
        let mut words = Vec::new();
        for _ in 0..lines {
            let end = rest.iter().position(|&b| b == b'\n').expect("a line ends");
            words.extend(String::from_utf8_lossy(&rest[..end]).split_whitespace().map(str::to_owned));
            rest = &rest[end + 1..];
        }
        Self { words, payload: rest.to_vec() }
    }

    fn number<T: std::str::FromStr>(&self, at: usize) -> T {
        self.words[at].parse().unwrap_or_else(|_| panic!("a number at word {at}: {}", self.words[at]))
    }

    fn count(&self) -> usize {
        if self.words[1] == "PTM_FORMAT_JPEG_RGB" { 18 } else { 9 }
    }

    /// Number `k` of the line `line` of those with a number for each plane.
    fn of_plane(&self, line: usize, k: usize) -> i64 {
        self.number(17 + line * self.count() + k)
    }

    fn planes(&self) -> Vec<Vec<u8>> {
        let n = self.count();
        let mut at = 0;
        let mut take = |length: i64| {
            let part = self.payload[at..at + length as usize].to_vec();
            at += length as usize;
            part
        };
        let parts: Vec<(Vec<u8>, Vec<u8>)> =
            (0..n).map(|k| (take(self.of_plane(5, k)), take(self.of_plane(6, k)))).collect();
        assert_eq!(at, self.payload.len());
        let mut planes: Vec<Vec<u8>> = parts.iter().map(|(jpeg, _)| grey(jpeg)).collect();
        for step in 0..n as i64 {
            let i = (0..n).find(|&k| self.of_plane(3, k) == step).expect("a plane of each step");
            let reference = self.of_plane(4, i);
            if reference >= 0 {
                for t in 0..planes[i].len() {
                    let r = i32::from(planes[reference as usize][t]);
                    let r = if self.of_plane(0, i) & 1 == 1 { 255 - r } else { r };
                    planes[i][t] = (i32::from(planes[i][t]) - 128 + r).rem_euclid(256) as u8;
                }
            }
            for record in parts[i].1.chunks(5) {
                let texel = u32::from_be_bytes(record[..4].try_into().unwrap()) as usize;
                planes[i][texel] = record[4];
            }
        }
        planes
    }

    fn size(&self) -> Size {
        Size::new(self.number(2), self.number(3))
    }

    fn coefficient(&self, k: usize, byte: u8) -> f64 {
        (f64::from(byte) - self.number::<f64>(10 + k)) * self.number::<f64>(4 + k)
    }
}

fn grey(jpeg: &[u8]) -> Vec<u8> {
    image::load_from_memory_with_format(jpeg, image::ImageFormat::Jpeg).unwrap().to_luma8().into_raw()
}

fn weights(light: Direction) -> [f64; 6] {
    let (u, v) = (light.x(), light.y());
    [u * u, v * v, u * v, u, v, 1.0]
}

/// Compares the library's reading of a compressed file with that of the decoder above.
fn assert_read_alike(file: &[u8], every: usize) {
    let map = Parsed::of(file, 14);
    let planes = map.planes();
    let Size { width, height } = map.size();
    let field = decode_field(file, &job()).unwrap().field;
    assert_eq!((field.size(), field.space()), (map.size(), Space::Srgb));
    for texel in (0..width * height).step_by(every) {
        let (x, y) = (texel % width, texel / width);
        let stored = (height - 1 - y) * width + x;
        for light in
            [Direction::from_disk(0.0, 0.0), Direction::from_disk(0.6, -0.3), Direction::from_disk(-0.2, 0.7)]
        {
            let w = weights(light);
            let polynomial = |from: usize| {
                (0..6).map(|k| map.coefficient(k, planes[from + k][stored]) * w[k]).sum::<f64>()
            };
            for (channel, ours) in field.value(x, y, light).into_iter().enumerate() {
                let truth = match planes.len() {
                    18 => polynomial(6 * channel) / 255.0,
                    _ => polynomial(0) / 255.0 * f64::from(planes[6 + channel][stored]) / 255.0,
                };
                assert!(
                    (f64::from(ours) - truth).abs() < 1e-5 * (1.0 + truth.abs()),
                    "({x}, {y}): {ours}, {truth}"
                );
            }
        }
    }
}

/// A field whose planes are smooth and alike, as those of photographs are, with an edge that wraps residuals around.
fn smooth(layout: &PlaneLayout, size: Size) -> ReflectanceField {
    let mut planes = Planes::zeros(size, layout.planes(6));
    let count = planes.count();
    for (k, plane) in planes.iter_mut().enumerate() {
        let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
        let gain = 0.3 + 0.1 * (k % 3) as f32;
        for (i, value) in plane.iter_mut().enumerate() {
            let (x, y) = ((i % size.width) as f32, (i / size.width) as f32);
            let wave = 0.5 * (0.21 * x + 0.13 * y).sin() + 0.3 * (0.4 * y - 0.1 * x).cos();
            let edge = if x > 20.0 && k == 1 { 0.64 } else { 0.0 };
            *value = if count == 9 && k >= 6 { 0.6 + 0.2 * wave } else { sign * gain * wave + edge };
        }
    }
    ReflectanceField::new(Basis::Ptm, layout.clone(), Space::Srgb, planes).unwrap()
}

#[test]
fn compressed_maps_are_read_by_the_other_decoder_and_alike() {
    for layout in [PlaneLayout::RGB, PlaneLayout::LRGB, PlaneLayout::LUMINANCE] {
        let field = smooth(&layout, Size::new(45, 31));
        let file = encode_field(&field, FieldFormat::PtmJpeg { quality: 95 }, None, &job()).unwrap();
        let map = Parsed::of(&file, 14);
        assert_eq!((map.words[0].as_str(), map.size()), ("PTM_1.2", field.size()));
        assert_read_alike(&file, 1);
        let read = decode_field(&file, &job()).unwrap().field;
        let mut squares = 0.0;
        let light = Direction::from_disk(0.3, -0.4);
        for (x, y) in (0..31).flat_map(|y| (0..45).map(move |x| (x, y))) {
            for (a, b) in field.value(x, y, light).into_iter().zip(read.value(x, y, light)) {
                squares += f64::from(a - b).powi(2);
            }
        }
        let rms = (squares / (45.0 * 31.0 * 3.0)).sqrt();
        assert!(rms < 0.02, "{layout:?}: {rms}");
    }
}

#[test]
fn prediction_inversion_and_side_information_are_written_and_shorten_the_file() {
    let field = smooth(&PlaneLayout::RGB, Size::new(96, 64));
    let file = encode_field(&field, FieldFormat::PtmJpeg { quality: 75 }, None, &job()).unwrap();
    let map = Parsed::of(&file, 14);
    let numbers = |line: usize| (0..18).map(|k| map.of_plane(line, k)).collect::<Vec<_>>();
    assert!(numbers(4).iter().filter(|&&reference| reference >= 0).count() >= 4, "{:?}", numbers(4));
    assert!(numbers(0).contains(&1), "no plane is predicted from an inverted one: {:?}", numbers(0));
    let whole = encode_field(&field, FieldFormat::Ptm, None, &job()).unwrap();
    assert!(3 * file.len() < whole.len(), "{} against {}", file.len(), whole.len());
    assert_read_alike(&file, 1);
    // The edge of one plane is half of the range of a byte: its residual wraps around there.
    assert!(numbers(6).iter().sum::<i64>() > 0, "no texel is corrected: {:?}", numbers(6));
    let noisy = random_field(Basis::Ptm, PlaneLayout::RGB, Space::Srgb, Size::new(24, 24), 5);
    let file = encode_field(&noisy, FieldFormat::PtmJpeg { quality: 90 }, None, &job()).unwrap();
    assert_read_alike(&file, 1);
}

/// A compressed file made by hand: a plane that is predicted from an inverted one and has a correction.
#[test]
fn a_file_made_by_hand_is_read_as_the_format_says() {
    let size = Size::new(16, 8);
    let mut random = Stream::new(4, Purpose::Sample, [0]);
    let jpeg = |random: &mut Stream| {
        let base = random.below(200) as u8;
        let samples: Vec<u8> = (0..128).map(|i| base + (i % 16) as u8 + (i / 16) as u8).collect();
        let mut out = Vec::new();
        image::codecs::jpeg::JpegEncoder::new_with_quality(&mut out, 95)
            .encode(&samples, size.width as u32, size.height as u32, image::ExtendedColorType::L8)
            .unwrap();
        out
    };
    let files: Vec<Vec<u8>> = (0..9).map(|_| jpeg(&mut random)).collect();
    let corrections = [0u8, 0, 0, 17, 200, 0, 0, 0, 3, 9];
    let sizes = files.iter().map(|f| f.len().to_string()).collect::<Vec<_>>().join(" ");
    let header = format!(
        "PTM_1.2\nPTM_FORMAT_JPEG_LRGB\n16\n8\n2 2 2 2 2 1\n160 160 160 127 127 0\n95\n0 1 0 0 0 1 0 0 0\n\
         0 0 0 0 0 0 0 0 0\n0 0 0 0 0 0 0 0 0\n4 8 3 0 1 7 5 2 6\n-1 5 -1 -1 -1 0 7 -1 7\n{sizes}\n\
         0 10 0 0 0 0 0 0 0\n"
    );
    let mut file = header.into_bytes();
    for (k, jpeg) in files.iter().enumerate() {
        file.extend(jpeg);
        file.extend(if k == 1 { &corrections[..] } else { &[] });
    }
    assert_read_alike(&file, 1);
    let message = |from: &str, to: &str| {
        let text = String::from_utf8_lossy(&file[..300]).replace(from, to);
        let broken = [text.as_bytes(), &file[300..]].concat();
        decode_field(&broken, &job()).map(drop).map_err(|e| e.message().to_owned())
    };
    // The replaced words keep their lengths.
    assert!(message("\n0 1 0 0 0 1 0 0 0\n", "\n0 2 0 0 0 1 0 0 0\n").unwrap_err().contains("motion"));
    assert!(message("-1 5 -1", "-1 1 -1").unwrap_err().contains("decoded after it"));
    assert!(message("4 8 3 0", "4 8 3 3").unwrap_err().contains("names one twice"));
    let mut beyond = file.clone();
    let at = beyond.windows(10).position(|w| w == corrections).unwrap();
    beyond[at + 2] = 1;
    let error = decode_field(&beyond, &job()).unwrap_err();
    assert!(
        error.message().contains("plane 2 of 9") && error.message().contains("texel 273 of 128"),
        "{error}"
    );
}

#[test]
fn the_tablet_of_hp_labs_is_read_alike_and_upright() {
    let Some(path) = data("ptm/tablet1.ptm") else { return };
    let file = std::fs::read(path).unwrap();
    assert_read_alike(&file, 37);
    // Light from the upper left: the rim of the tablet that faces it, left and above, is lit.
    let field = decode_field(&file, &job()).unwrap().field;
    let mean = |light: Direction, xs: std::ops::Range<usize>, ys: std::ops::Range<usize>| {
        let (mut sum, mut count) = (0.0, 0.0);
        for (x, y) in ys.flat_map(|y| xs.clone().map(move |x| (x, y))) {
            sum += field.value(x, y, light).iter().sum::<f32>();
            count += 3.0;
        }
        sum / count
    };
    let (above, below) = (Direction::from_disk(0.0, 0.8), Direction::from_disk(0.0, -0.8));
    let top = mean(above, 150..350, 20..120) / mean(below, 150..350, 20..120);
    let bottom = mean(above, 150..350, 392..492) / mean(below, 150..350, 392..492);
    assert!(top > bottom, "light from above: top {top}, bottom {bottom}");
}

#[test]
fn luminance_with_colour_differences_is_read_by_its_matrix() {
    let numbers = "0.5 1.25 2 0.3 0.75 1\n128 100 -20 127 255 0\n";
    let matrix = [1.0, 1.4, 0.0, -179.0, 1.0, -0.7, -0.34, 133.0, 1.0, 0.0, 1.77, -226.0, 0.0, 0.0, 0.0, 1.0];
    let words = matrix.map(|n: f64| n.to_string()).join(" ");
    for (version, interleaved) in [("PTM_1.2", false), ("PTM_1.1", true)] {
        let mut random = Stream::new(8, Purpose::Sample, [0]);
        let bytes: Vec<u8> = (0..15 * 8).map(|_| random.below(256) as u8).collect();
        let header = format!("{version}\nPTM_FORMAT_LUM\n5\n3\n{numbers}{words}\n");
        let file = [header.as_bytes(), &bytes].concat();
        let listening = job();
        let field = decode_field(&file, &listening).unwrap().field;
        assert!(listening.remarks()[0].contains("PTM_FORMAT_LUM"));
        let map = Parsed::of(&file, 7);
        let light = Direction::from_disk(0.4, 0.5);
        for (x, y) in (0..3).flat_map(|y| (0..5).map(move |x| (x, y))) {
            let i = (2 - y) * 5 + x;
            let byte = |k: usize| match (interleaved, k < 6) {
                (true, _) => bytes[8 * i + k],
                (false, true) => bytes[6 * i + k],
                (false, false) => bytes[90 + 2 * i + k - 6],
            };
            let w = weights(light);
            let l: f64 = (0..6).map(|k| map.coefficient(k, byte(k)) * w[k]).sum();
            let (cr, cb) = (f64::from(byte(6)), f64::from(byte(7)));
            for (c, ours) in field.value(x, y, light).into_iter().enumerate() {
                let row = &matrix[4 * c..][..4];
                let truth = (row[0] * l + row[1] * cr + row[2] * cb + row[3]) / 255.0;
                assert!(
                    (f64::from(ours) - truth).abs() < 1e-4 * (1.0 + truth.abs()),
                    "{ours} against {truth}"
                );
            }
        }
    }
}

#[test]
fn a_compressed_map_whose_plane_has_another_size_says_which() {
    let field = smooth(&PlaneLayout::LRGB, Size::new(20, 12));
    let file = encode_field(&field, FieldFormat::PtmJpeg { quality: 90 }, None, &job()).unwrap();
    let text = String::from_utf8_lossy(&file).replacen("\n20\n12\n", "\n20\n13\n", 1);
    assert!(text.starts_with("PTM_1.2\nPTM_FORMAT_JPEG_LRGB\n20\n13\n"));
    let at = file.windows(7).position(|w| w == b"\n20\n12\n").unwrap();
    let mut broken = file.clone();
    broken[at + 5] = b'3';
    let error = decode_field(&broken, &job()).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Invalid);
    assert!(
        error.message().contains("of 9 of the texture map") && error.message().contains("20 x 12"),
        "{error}"
    );
}
