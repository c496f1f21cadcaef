//! `.btf` files: those of an independent writer are read value by value; those of the library are read by an
//! independent decoder.

use std::fs;
use std::io::{Seek, SeekFrom, Write};
use std::sync::Arc;

use half::f16;
use relume::direction::{Direction, Directions};
use relume::format::bonn::{
    BonnBtf, BtfColorModel, BtfFactors, BtfScalar, FactorShape, encode_dfmf, encode_fmf,
};
use relume::format::{Content, read};
use relume::numeric::random::{Purpose, Stream};
use relume::{Error, ErrorKind, Job, Limits, Planes, Samples, Size};

use crate::btf_files::{BtfFile, Head, MATRIX, MEAN, bdi, dfmf, floats, fmf, pvf, small_btf_files, words};
use crate::support::job;

fn decode(bytes: &[u8]) -> Result<BonnBtf, Error> {
    BonnBtf::decode(Arc::new(bytes.to_vec()), &job())
}

fn message(bytes: &[u8]) -> String {
    decode(bytes).expect_err("a broken file").message().to_owned()
}

/// Every value of every image, within rounding to `f32`; `model` gives the channels from those stored.
fn assert_reads(name: &str, file: &BtfFile, model: impl Fn([f64; 3]) -> [f64; 3]) {
    let btf = decode(&file.bytes).unwrap_or_else(|e| panic!("{name}: {e}"));
    let (head, texels) = (&file.head, file.head.texels());
    assert_eq!(btf.pairs().len(), head.pairs(), "{name}");
    assert_eq!(btf.size(), Size::new(head.width as usize, head.height as usize));
    for pair in (0..head.pairs()).rev() {
        let planes = btf.planes(pair, &job()).unwrap();
        for texel in 0..texels {
            let stored: Vec<f64> = (0..head.channels.len()).map(|c| file.value(pair, c, texel)).collect();
            let expected = match stored.as_slice() {
                &[a, b, c] => model([a, b, c]).to_vec(),
                others => others.to_vec(),
            };
            for (channel, expected) in expected.into_iter().enumerate() {
                let found = f64::from(planes.plane(channel)[texel]);
                let near = (found - expected).abs() < 1e-5 * (1.0 + expected.abs());
                assert!(
                    near,
                    "{name}: pair {pair}, channel {channel}, texel {texel}: {found} for {expected}"
                );
            }
        }
    }
}

fn yuv([y, u, v]: [f64; 3]) -> [f64; 3] {
    [y + 1.13983 * v, y - 0.39465 * u - 0.5806 * v, y + 2.03211 * u]
}

#[test]
fn full_factorisations_are_read_in_every_form() {
    for size in [2, 4, 8] {
        for transposed in [false, true] {
            for (signature, extended) in [
                ("!FMF06FC", None),
                ("!FMF06FCR", None),
                ("!FMF12FCER", Some((0, 0))),
                ("!FMF12FCER", Some((1, 0))),
                ("!FMF12FCER", Some((1, 1))),
                ("!FMF12FCER", Some((2, 1))),
            ] {
                let file = fmf(Head::new(signature, &[4, 2, 3], 5, 3), size, transposed, extended);
                assert_reads(&format!("{signature} {size} {transposed}"), &file, |v| v);
            }
        }
    }
}

#[test]
fn decorrelated_factorisations_are_read_in_their_colour_models() {
    for transposed in [false, true] {
        let file = |model| dfmf(Head::new("!DFMF08FCR", &[3, 4], 4, 3), [2, 4, 8], transposed, model);
        assert_reads("RGB", &file(0), |v| v);
        assert_reads("YUV", &file(1), yuv);
        let pca = |v: [f64; 3]| {
            let sum = |c: usize| (0..3).map(|k| v[k] * f64::from(MATRIX[k][c])).sum::<f64>();
            std::array::from_fn(|c| sum(c) + f64::from(MEAN[c]))
        };
        assert_reads("PCA", &file(3), pca);
        let log = |[y, u, v]: [f64; 3]| yuv([y.exp() - 1e-5, u * y.exp(), v * y.exp()]);
        assert_reads("log YUV", &file(11), log);
        assert_reads("log RGB", &file(12), |v| v.map(|v| v.exp() - 1e-5));
    }
}

#[test]
fn factorisations_for_each_view_are_read_in_both_forms() {
    for signature in ["!PVF06FC", "!PVF06FCR"] {
        for images in [false, true] {
            let file = pvf(Head::new(signature, &[4, 2, 3], 5, 3), 2, images);
            assert_reads(&format!("{signature} {images}"), &file, |v| v);
        }
    }
}

#[test]
fn images_are_read_from_memory_and_from_the_file() {
    let folder = tempfile::tempdir().unwrap();
    for (lines, compression, missing) in [(1, 0, &[][..]), (2, 0, &[]), (7, 2, &[]), (1, 2, &[0, 4, 13])] {
        let file = bdi(Head::new("!BDIF06R2!", &[2, 3], 5, 3), lines, compression, missing);
        assert_reads("BDI", &file, |v| v);
        let path = folder.path().join("images.btf");
        fs::write(&path, &file.bytes).unwrap();
        let (on_disk, in_memory) = (BonnBtf::open(&path, &job()).unwrap(), decode(&file.bytes).unwrap());
        for pair in 0..file.head.pairs() {
            let planes = on_disk.planes(pair, &job()).unwrap();
            assert_eq!(planes, in_memory.planes(pair, &job()).unwrap());
        }
    }
    let listening = job();
    let sparse = bdi(Head::new("!BDIF06R2!", &[2], 5, 3), 1, 2, &[3, 4]);
    BonnBtf::decode(Arc::new(sparse.bytes), &listening).unwrap();
    assert!(
        listening.remarks()[0].contains("2 of the 15 texels are not stored"),
        "{:?}",
        listening.remarks()
    );
}

#[test]
fn images_of_a_file_on_disk_are_gathered_within_the_memory_that_is_free() {
    let folder = tempfile::tempdir().unwrap();
    let file = bdi(Head::new("!BDIF06R2!", &[9, 7], 20, 10), 3, 2, &[7]);
    let path = folder.path().join("images.btf");
    fs::write(&path, &file.bytes).unwrap();
    // An image has 1200 bytes in the file and 2400 in memory: one, three and all at a time.
    for max_bytes in [8_000, 24_000, 1 << 20] {
        let tight = Job::new(Limits { max_bytes, ..Limits::default() });
        let btf = BonnBtf::open(&path, &tight).unwrap();
        for pair in [0, 1, 2, 3, 9, 15, 4, 0] {
            let planes = btf.planes(pair, &tight).unwrap();
            for texel in 0..200 {
                assert_eq!(
                    f64::from(planes.plane(2)[texel]),
                    file.value(pair, 2, texel),
                    "{max_bytes} {pair}"
                );
            }
        }
        assert!(tight.free_bytes() >= max_bytes / 2, "{} of {max_bytes} are free", tight.free_bytes());
        drop(btf);
        assert_eq!(tight.free_bytes(), max_bytes);
    }
}

/// A file with holes: only its head, the lengths of its chunks and one texel are written.
#[test]
fn values_beyond_4_gib_are_found() {
    let (side, lines, texel_bytes) = (690u32, 200u32, 40 * 40 * 6u64);
    let head = Head::new("!BDIF06R2!", &[40; 40], side, side);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("large.btf");
    let mut file = fs::File::create(&path).unwrap();
    let mut start = [head.bytes(), words(&[lines]), vec![0]].concat();
    start.extend(vec![1; head.texels()]);
    start.extend(words(&[0]));
    file.write_all(&start).unwrap();
    let mut at = start.len() as u64;
    for first in (0..side).step_by(lines as usize) {
        let length = u64::from(lines.min(side - first) * side) * texel_bytes;
        file.seek(SeekFrom::Start(at)).unwrap();
        file.write_all(&words(&[length as u32])).unwrap();
        at += 4 + length;
    }
    assert!(at > 1 << 32, "{at} bytes");
    file.set_len(at).unwrap();
    // The last pair of the last texel.
    file.seek(SeekFrom::Start(at - 6)).unwrap();
    file.write_all(&crate::btf_files::scalars(2, &[0.5, -2.0, 700.0])).unwrap();
    drop(file);
    let roomy = Job::default();
    let btf = BonnBtf::open(&path, &roomy).unwrap();
    let planes = btf.planes(1599, &roomy).unwrap();
    let last = head.texels() - 1;
    assert_eq!([0, 1, 2].map(|channel| planes.plane(channel)[last]), [0.5, -2.0, 700.0]);
    assert!(planes.plane(0)[..last].iter().all(|value| *value == 0.0));
    assert_eq!(read_file_error(&path), ErrorKind::Limit);
}

/// What a job that has not the memory for the whole file says of it.
fn read_file_error(path: &std::path::Path) -> ErrorKind {
    let tight = Job::new(Limits { max_bytes: 1 << 30, ..Limits::default() });
    relume::format::open(path, &tight).unwrap_err().kind()
}

#[test]
fn the_description_of_every_version_is_read() {
    for version in 0..5 {
        let mut head = Head::new("!FMF06FC", &[2, 2], 3, 2);
        (head.version, head.cosine) = (version, 1);
        if version == 4 {
            head.channels = ["430nm", "500nm", "570nm", "640nm"].map(str::to_owned).to_vec();
        }
        let file = fmf(head, 4, false, None);
        assert_reads("spectral", &file, |v| v);
        let btf = decode(&file.bytes).unwrap();
        assert_eq!(btf.has_cosine(), version > 1);
        assert_eq!(btf.channels(), file.head.channels);
        assert_eq!(btf.texels_per_mm(), Some(10.0));
        assert_eq!(btf.image(0, &job()).is_ok(), version < 4);
    }
}

#[test]
fn pairs_are_in_the_order_of_the_file() {
    let file = fmf(Head::new("!FMF06FC", &[2, 3], 3, 2), 4, false, None);
    let btf = decode(&file.bytes).unwrap();
    for (pair, (view, light)) in btf.pairs().iter().zip(file.head.places()) {
        let (of_view, lights) = &file.head.views[view];
        for (found, [polar, azimuth]) in [(pair.view, *of_view), (pair.light, lights[light])] {
            let expected = Direction::from_angles(f64::from(polar), f64::from(azimuth));
            assert!(found.dot(expected) > 1.0 - 1e-12);
        }
    }
    let image = btf.image(3, &job()).unwrap();
    let Samples::F32(samples) = image.samples() else { panic!("floats") };
    assert!((f64::from(samples[4 * 3 + 2]) - file.value(3, 2, 4)).abs() < 1e-6);
}

#[test]
fn every_kind_is_recognised_by_its_content() {
    for (name, file) in small_btf_files() {
        let opened = read(&file.bytes[..], "a", &job()).unwrap();
        assert_eq!(opened.content(), Content::Btf, "{name}");
        assert!(opened.clone().into_field().unwrap_err().to_string().contains("BTF"), "{name}");
        assert_eq!(opened.into_btf().unwrap().pairs().len(), file.head.pairs(), "{name}");
    }
}

/// Images from factors, by their definition.
fn from_factors(factors: &BtfFactors, channels: usize, pair: usize, channel: usize, texel: usize) -> f64 {
    let count = factors.count();
    let (row, first) = match factors.shape {
        FactorShape::Functions => (pair * channels + channel, 0),
        FactorShape::Coefficients => (pair, channel * count),
    };
    let term = |k: usize| {
        let function = f64::from(factors.functions[row * count + k]);
        function * f64::from(factors.coefficients.plane(first + k)[texel])
    };
    (0..count).map(term).sum()
}

#[test]
fn linear_factors_give_the_images_without_decoding_them() {
    let files = [
        fmf(Head::new("!FMF06FC", &[4, 2, 3], 5, 3), 4, false, None),
        fmf(Head::new("!FMF06FC", &[4, 2, 3], 5, 3), 4, true, None),
        dfmf(Head::new("!DFMF08FCR", &[3, 4], 4, 3), [4; 3], false, 0),
        dfmf(Head::new("!DFMF08FCR", &[3, 4], 4, 3), [4; 3], true, 1),
        dfmf(Head::new("!DFMF08FCR", &[3, 4], 4, 3), [4; 3], false, 3),
        dfmf(Head::new("!DFMF08FCR", &[3, 4], 4, 3), [4; 3], true, 4),
    ];
    for (i, file) in files.iter().enumerate() {
        let btf = decode(&file.bytes).unwrap();
        let factors = btf.linear_factors(&job()).unwrap();
        for pair in 0..file.head.pairs() {
            let planes = btf.planes(pair, &job()).unwrap();
            for (channel, texel) in (0..3).flat_map(|c| (0..file.head.texels()).map(move |t| (c, t))) {
                let found = from_factors(&factors, 3, pair, channel, texel);
                let expected = f64::from(planes.plane(channel)[texel]);
                assert!((found - expected).abs() < 1e-5, "file {i}: {found} {expected}");
            }
        }
    }
}

#[test]
fn values_that_are_not_linear_have_no_linear_factors() {
    let refused = [
        fmf(Head::new("!FMF12FCER", &[2], 3, 2), 4, false, Some((1, 1))),
        dfmf(Head::new("!DFMF08FCR", &[3], 4, 3), [4; 3], false, 11),
        pvf(Head::new("!PVF06FC", &[3], 4, 3), 4, false),
        bdi(Head::new("!BDIF06R2!", &[3], 4, 3), 1, 0, &[]),
    ];
    for file in refused {
        let error = decode(&file.bytes).unwrap().linear_factors(&job()).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::Unsupported);
        assert!(error.message().contains("factor its images instead"), "{error}");
    }
    let file = dfmf(Head::new("!DFMF08FCR", &[3], 4, 3), [4; 3], false, 11);
    let btf = decode(&file.bytes).unwrap();
    assert_eq!(btf.color_model(), Some(BtfColorModel::LogYRatios));
    for (channel, factors) in btf.stored_factors(&job()).unwrap().iter().enumerate() {
        for pair in 0..3 {
            let found = from_factors(factors, 1, pair, 0, 7);
            assert!((found - file.value(pair, channel, 7)).abs() < 1e-6);
        }
    }
}

// Writing.

/// Every view with every light, of `count` directions, in a shuffled order.
fn square_pairs(count: usize) -> Vec<Directions> {
    let direction = |i: usize| Direction::from_angles(0.1 * i as f64, 1.9 * i as f64);
    let pair = |i: usize| {
        let i = i * 7 % (count * count);
        Directions { light: direction(i % count), view: direction(i / count) }
    };
    (0..count * count).map(pair).collect()
}

fn random_factors(shape: FactorShape, rows: usize, count: usize, size: Size, seed: u64) -> BtfFactors {
    let mut random = Stream::new(seed, Purpose::Sample, [1]);
    let mut numbers = |n: usize| -> Vec<f32> { (0..n).map(|_| random.unit() as f32 - 0.4).collect() };
    let functions = numbers(rows * count);
    let coefficients = Planes::from_vec(size, count, numbers(size.texels() * count)).unwrap();
    BtfFactors { shape, functions, coefficients, singular: numbers(count) }
}

/// A decoder of what the usual reader knows, from the description of the format alone.
struct Decoder<'a>(&'a [u8]);

/// A decoded file: angles of views and lights, the size, the colour model, and for each matrix U and S V.
struct Decoded {
    views: Vec<[f32; 2]>,
    lights: Vec<[f32; 2]>,
    size: [usize; 2],
    model: u32,
    matrices: Vec<(usize, Vec<f32>, Vec<f32>)>,
}

impl Decoder<'_> {
    fn bytes(&mut self, count: usize) -> &[u8] {
        let (taken, rest) = self.0.split_at(count);
        self.0 = rest;
        taken
    }

    fn word(&mut self) -> u32 {
        u32::from_le_bytes(self.bytes(4).try_into().unwrap())
    }

    fn float(&mut self) -> f32 {
        f32::from_bits(self.word())
    }

    fn scalars(&mut self, size: u8, count: usize) -> Vec<f32> {
        let bytes = self.bytes(usize::from(size) * count);
        match size {
            2 => bytes.chunks(2).map(|b| f16::from_le_bytes([b[0], b[1]]).to_f32()).collect(),
            4 => bytes.chunks(4).map(|b| f32::from_le_bytes(b.try_into().unwrap())).collect(),
            _ => panic!("scalars of {size} bytes"),
        }
    }

    fn matrix(&mut self, rows: usize, columns: usize) -> (usize, Vec<f32>, Vec<f32>) {
        let size = self.bytes(1)[0];
        let count = self.word() as usize;
        assert_eq!([self.word() as usize, self.word() as usize], [rows, columns]);
        self.scalars(size, count);
        (count, self.scalars(size, rows * count), self.scalars(size, columns * count))
    }

    fn decode(mut self) -> Decoded {
        let signature = self.bytes(10).to_vec();
        let before = self.0.len();
        let (length, version) = (self.word(), self.word());
        self.bytes(240 + 16);
        assert!(version == 4 && self.word() == 0, "the cosine flag is 0");
        let text = self.word() as usize;
        self.bytes(text);
        assert_eq!(self.word(), 3, "channels");
        for name in [b"R", b"G", b"B"] {
            assert_eq!(self.word(), 1);
            assert_eq!(self.bytes(1), name);
        }
        assert_eq!((before - self.0.len()) as u32, length);
        let (mut views, mut lights) = (Vec::new(), Vec::new());
        for view in 0..self.word() {
            views.push([self.float(), self.float()]);
            let of_view: Vec<[f32; 2]> = (0..self.word()).map(|_| [self.float(), self.float()]).collect();
            assert!(view == 0 || of_view == lights, "the lights of all views are the same");
            lights = of_view;
        }
        let size = [self.word() as usize, self.word() as usize];
        let rotations = self.word() as usize;
        self.bytes(36 * rotations);
        let (pairs, texels) = (views.len() * lights.len(), size[0] * size[1]);
        assert_eq!(views.len(), lights.len(), "as many views as lights");
        let (model, matrices) = match signature.as_slice() {
            b"!FMF12FCER" => {
                let extended = self.bytes(1)[0];
                assert!(extended < 1 || self.word() == 0, "values are no logarithms");
                assert!(extended < 2 || self.word() * self.word() == 0, "there is no height map");
                self.word();
                (0, vec![self.matrix(3 * pairs, texels)])
            }
            b"!DFMF08FCR" => {
                let (_, model) = (self.word(), self.word());
                self.bytes(48);
                (model, (0..3).map(|_| self.matrix(pairs, texels)).collect())
            }
            other => panic!("{other:?}"),
        };
        assert!(self.0.is_empty(), "the file ends with its data");
        Decoded { views, lights, size, model, matrices }
    }
}

impl Decoded {
    /// The number in the file of the pair whose directions are nearest.
    fn number(&self, pair: &Directions) -> usize {
        let nearest = |angles: &[[f32; 2]], to: Direction| {
            let cosine = |a: &[f32; 2]| Direction::from_angles(a[0].into(), a[1].into()).dot(to);
            let best = (0..angles.len()).max_by(|&a, &b| cosine(&angles[a]).total_cmp(&cosine(&angles[b])));
            best.filter(|&i| cosine(&angles[i]) > 1.0 - 1e-9).expect("the direction is in the file")
        };
        nearest(&self.views, pair.view) * self.lights.len() + nearest(&self.lights, pair.light)
    }

    fn product(&self, matrix: usize, row: usize, texel: usize) -> f64 {
        let (count, u, sxv) = &self.matrices[matrix];
        let term = |k: usize| f64::from(u[row * count + k]) * f64::from(sxv[texel * count + k]);
        (0..*count).map(term).sum()
    }
}

/// The most that a sum of products can change when both factors are rounded to halves.
fn half_error(factors: &BtfFactors, row: usize, texel: usize) -> f64 {
    const HALF: f64 = 1.0 / 2048.0;
    // The least normal half; below, the error is absolute.
    const LEAST: f64 = 1.0 / 16384.0;
    let count = factors.count();
    let rounding = |v: f64| v.abs().max(LEAST) * HALF;
    let term = |k: usize| {
        let (u, v) =
            (f64::from(factors.functions[row * count + k]), f64::from(factors.coefficients.plane(k)[texel]));
        u.abs() * rounding(v) + v.abs() * rounding(u) + rounding(u) * rounding(v)
    };
    (0..count).map(term).sum()
}

#[test]
fn written_files_come_back_within_half_floats_by_an_independent_decoder() {
    let (pairs, size) = (square_pairs(4), Size::new(5, 3));
    let factors = random_factors(FactorShape::Functions, 48, 6, size, 1);
    let bytes = encode_fmf(&pairs, &factors, BtfScalar::Half, &job()).unwrap();
    let decoded = Decoder(&bytes).decode();
    assert_eq!((decoded.size, decoded.model), ([5, 3], 0));
    let by_us = decode(&bytes).unwrap();
    for (i, pair) in pairs.iter().enumerate() {
        let number = decoded.number(pair);
        let planes = by_us.planes(number, &job()).unwrap();
        for (channel, texel) in (0..3).flat_map(|c| (0..15).map(move |t| (c, t))) {
            let found = decoded.product(0, number * 3 + channel, texel);
            let expected = from_factors(&factors, 3, i, channel, texel);
            let most = half_error(&factors, i * 3 + channel, texel);
            assert!((found - expected).abs() <= most, "{i} {channel} {texel}: {found} {expected} {most}");
            assert!((f64::from(planes.plane(channel)[texel]) - found).abs() < 1e-6);
        }
    }
}

#[test]
fn written_channels_come_back_within_half_floats_by_an_independent_decoder() {
    let (pairs, size) = (square_pairs(3), Size::new(4, 3));
    let channels =
        [2, 3, 5].map(|count| random_factors(FactorShape::Coefficients, 9, count, size, count as u64));
    for model in [BtfColorModel::Rgb, BtfColorModel::LogYRatios] {
        let bytes = encode_dfmf(&pairs, &channels, model, BtfScalar::Half, &job()).unwrap();
        let decoded = Decoder(&bytes).decode();
        assert_eq!(decoded.model, model.number());
        let by_us = decode(&bytes).unwrap();
        for (i, pair) in pairs.iter().enumerate() {
            let number = decoded.number(pair);
            let planes = by_us.planes(number, &job()).unwrap();
            for texel in 0..12 {
                let stored: [f64; 3] = std::array::from_fn(|c| decoded.product(c, number, texel));
                for (channel, factors) in channels.iter().enumerate() {
                    let expected = from_factors(factors, 1, i, 0, texel);
                    let most = half_error(factors, i, texel);
                    assert!((stored[channel] - expected).abs() <= most, "{i} {channel} {texel}");
                }
                let y = stored[0].exp();
                let rgb = if model == BtfColorModel::Rgb {
                    stored
                } else {
                    yuv([y - 1e-5, stored[1] * y, stored[2] * y])
                };
                for (channel, expected) in rgb.into_iter().enumerate() {
                    assert!((f64::from(planes.plane(channel)[texel]) - expected).abs() < 1e-5);
                }
            }
        }
    }
}

#[test]
fn floats_come_back_bit_by_bit() {
    let (pairs, size) = (square_pairs(2), Size::new(3, 2));
    let factors = random_factors(FactorShape::Functions, 12, 4, size, 9);
    let bytes = encode_fmf(&pairs, &factors, BtfScalar::Float, &job()).unwrap();
    let back = decode(&bytes).unwrap();
    let read = back.linear_factors(&job()).unwrap();
    assert_eq!((&read.coefficients, &read.singular), (&factors.coefficients, &factors.singular));
    for (i, pair) in back.pairs().iter().enumerate() {
        let from = pairs.iter().position(|p| p.light.dot(pair.light).min(p.view.dot(pair.view)) > 1.0 - 1e-9);
        let row = |factors: &BtfFactors, i: usize| factors.functions[i * 12..][..12].to_vec();
        assert_eq!(row(&read, i), row(&factors, from.unwrap()));
    }
    // Halves of halves are the same halves.
    let halves = encode_fmf(&pairs, &factors, BtfScalar::Half, &job()).unwrap();
    let again = decode(&halves).unwrap();
    let factors = again.linear_factors(&job()).unwrap();
    assert_eq!(encode_fmf(again.pairs(), &factors, BtfScalar::Half, &job()).unwrap(), halves);
}

#[test]
fn what_the_usual_reader_cannot_read_is_not_written() {
    let (pairs, size) = (square_pairs(2), Size::new(3, 2));
    let good = random_factors(FactorShape::Functions, 12, 2, size, 1);
    let refused = |pairs: &[Directions], factors: &BtfFactors| {
        encode_fmf(pairs, factors, BtfScalar::Half, &job()).unwrap_err().message().to_owned()
    };
    assert!(refused(&pairs[..3], &good).contains("3 pairs of 2 views and 2 lights"));
    let wide: Vec<Directions> = pairs.iter().chain(&square_pairs(3)).copied().collect();
    assert!(refused(&wide, &good).contains("are the same"));
    let one_view: Vec<Directions> =
        square_pairs(3).into_iter().filter(|pair| pair.view == Direction::ZENITH).collect();
    let narrow = random_factors(FactorShape::Functions, 9, 2, size, 1);
    assert!(refused(&one_view, &narrow).contains("1 views and 3 lights"));
    let other = BtfFactors { shape: FactorShape::Coefficients, ..good.clone() };
    assert!(refused(&pairs, &other).contains("depend on the pair"));
    let large = BtfFactors { functions: vec![1e5; 24], ..good.clone() };
    assert!(refused(&pairs, &large).contains("beyond 65,504"));
    assert!(encode_fmf(&pairs, &large, BtfScalar::Float, &job()).is_ok());
    let nan = BtfFactors { functions: vec![f32::NAN; 24], ..good };
    assert!(encode_fmf(&pairs, &nan, BtfScalar::Float, &job()).unwrap_err().message().contains("not finite"));
    let channels = [1, 2, 3].map(|count| random_factors(FactorShape::Coefficients, 4, count, size, 1));
    let model = encode_dfmf(&pairs, &channels, BtfColorModel::Lab, BtfScalar::Half, &job()).unwrap_err();
    assert!(model.message().contains("colour model 2"), "{model}");
}

#[test]
fn the_cosine_is_divided_out_of_functions() {
    let pairs = square_pairs(3);
    let factors = random_factors(FactorShape::Functions, 27, 2, Size::new(2, 2), 1);
    let divided = factors.clone().without_cosine(&pairs).unwrap();
    for (i, (a, b)) in factors.functions.iter().zip(&divided.functions).enumerate() {
        assert!((f64::from(*b) * pairs[i / 6].light.z() - f64::from(*a)).abs() < 1e-6);
    }
    let flat = vec![Directions::lit_from(Direction::new(1.0, 0.0, 0.0).unwrap()); 9];
    assert!(factors.clone().without_cosine(&flat).unwrap_err().message().contains("horizon"));
    assert!(factors.without_cosine(&pairs[..4]).is_err());
}

// Bad input.

/// A file in which the word at a distance from a text is another number.
fn with_word(bytes: &[u8], at: usize, word: u32) -> Vec<u8> {
    let mut changed = bytes.to_vec();
    changed[at..at + 4].copy_from_slice(&word.to_le_bytes());
    changed
}

#[test]
fn lying_counts_are_refused_in_words_before_memory_is_taken() {
    let head = Head::new("!FMF06FC", &[2, 2], 3, 2);
    let file = fmf(head.clone(), 4, false, None);
    let start = head.bytes().len();
    let size = start - 8;
    let views = size - 2 * (12 + 16) - 4;
    let cases = [
        (8, 5, "says it has 5 bytes"),
        (8 + 4, 3, "the description"),
        (views, u32::MAX, "for its views"),
        (views, 0, "no pair"),
        (views + 12, u32::MAX, "the lights of a view"),
        (size, 0, "at least 1"),
        (size, u32::MAX, "longest side"),
        (size, 4, "12 x 8"),
        (start + 5, 0, "0 components"),
        (start + 5, 13, "13 components"),
        (start + 9, u32::MAX, "bytes for the matrix"),
        (start + 13, u32::MAX, "bytes for the matrix"),
    ];
    for (at, word, expected) in cases {
        let found = message(&with_word(&file.bytes, at, word));
        assert!(found.contains(expected), "{at} {word}: {found}");
    }
    let longer = [&file.bytes[..], &[0; 7]].concat();
    assert!(message(&longer).contains("7 bytes after its data"));
    let mut odd = file.bytes;
    odd[start + 4] = 3;
    assert!(message(&odd).contains("numbers of 3 bytes"));
}

#[test]
fn angles_below_the_surface_and_numbers_that_are_not_finite_are_refused() {
    let head = Head::new("!FMF06FC", &[2, 2], 3, 2);
    for (angle, view) in [(1.7, true), (-0.1, true), (f32::NAN, true), (2.0, false), (f32::INFINITY, false)] {
        let mut broken = head.clone();
        if view {
            broken.views[1].0[0] = angle;
        } else {
            broken.views[1].1[1][0] = angle;
        }
        let found = message(&fmf(broken, 4, false, None).bytes);
        let expected = if view { "view 1 of the BTF file" } else { "light 1 of view 1" };
        assert!(found.contains(expected) && found.contains(&angle.to_string()), "{found}");
    }
    for size in [2, 4, 8] {
        let file = fmf(head.clone(), size, false, None);
        let last = file.bytes.len() - usize::from(size);
        let mut broken = file.bytes[..last].to_vec();
        broken.extend(crate::btf_files::scalars(size, &[f64::NAN]));
        let found = message(&broken);
        assert!(found.contains("number 17 of SxV of the matrix") && found.contains("not finite"), "{found}");
    }
    let images = bdi(Head::new("!BDIF06R2!", &[2], 3, 2), 1, 0, &[]);
    let mut broken = images.bytes;
    let at = broken.len() - 2;
    broken[at..].copy_from_slice(&f16::NAN.to_le_bytes());
    let btf = decode(&broken).unwrap();
    assert!(btf.planes(0, &job()).is_ok());
    let error = btf.planes(1, &job()).unwrap_err().message().to_owned();
    assert!(error.contains("image 1") && error.contains("'B' is NaN at texel (2, 1)"), "{error}");
}

#[test]
fn what_is_not_read_is_refused_by_name() {
    let head = |signature| Head::new(signature, &[2, 2], 3, 2);
    assert!(message(&bdi(head("!BDIF06R2!"), 1, 1, &[]).bytes).contains("bzip2"));
    assert!(message(&bdi(head("!BDIF06R2!"), 1, 9, &[]).bytes).contains("compression 9"));
    assert!(message(&bdi(head("!BDIF06R2!"), 1, 2, &[]).bytes[..40]).contains("truncated"));
    assert!(message(&fmf(head("!FMF12FCER"), 2, false, Some((3, 0))).bytes).contains("version 3"));
    assert!(message(&dfmf(head("!DFMF08FCR"), [2; 3], false, 8).bytes).contains("colour model 8"));
    let mut four = head("!DFMF08FCR");
    four.channels.push("N".to_owned());
    assert!(message(&dfmf(four, [2; 3], false, 11).bytes).contains("three channels"));
    assert!(message(b"!ABCD06FC and more").contains("begins with '!ABCD06FC '"));
    let file = pvf(head("!PVF06FC"), 2, false);
    let slots = file.head.bytes().len() + 4;
    assert!(message(&with_word(&file.bytes, slots, 3)).contains("factors of 3 views and directions of 2"));
    assert!(message(&with_word(&file.bytes, slots + 9, 7)).contains("7 weights of components"));
}

#[test]
fn memory_is_asked_of_the_job_before_it_is_taken() {
    let file = fmf(Head::new("!FMF06FC", &[40, 40], 60, 50), 2, false, None);
    let tight = Job::new(Limits { max_bytes: 1 << 15, ..Limits::default() });
    let error = BonnBtf::decode(Arc::new(file.bytes.clone()), &tight).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Limit, "{error}");
    let roomy = Job::new(Limits { max_bytes: 1 << 17, ..Limits::default() });
    let btf = BonnBtf::decode(Arc::new(file.bytes), &roomy).unwrap();
    // U of 240 rows and S V of 3000, of three components each, and S.
    assert_eq!(roomy.free_bytes(), (1 << 17) - 4 * (3 * 3240 + 3));
    drop(btf);
    assert_eq!(roomy.free_bytes(), 1 << 17);
}

#[test]
fn an_unknown_tail_of_the_description_is_refused() {
    // The length of the description counts from itself.
    let head = Head::new("!FMF06FC", &[2, 2], 3, 2);
    let file = fmf(head, 4, false, None);
    let length = u32::from_le_bytes(file.bytes[8..12].try_into().unwrap());
    let found = message(&with_word(&file.bytes, 8, length + 4));
    assert!(found.contains(&format!("says it has {} bytes", length + 4)), "{found}");
    assert_eq!(floats(&[1.0]), words(&[0x3f80_0000]));
}
