//! Web folders read and written by an independent decoder, from the description of the format alone: the JSON, JPEG
//! files one by one, and the formulas of the functions.

use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::path::Path;

use relume::field::{Basis, PlaneLayout};
use relume::format::web::{WebLayout, WebOptions, encode_web};
use relume::format::{Content, FieldFormat, decode_field, encode_field, open};
use relume::numeric::random::{Purpose, Stream};
use relume::workflow::convert::{ConvertOptions, convert};
use relume::{Direction, ErrorKind, Job, Limits, Named, ReflectanceField, Size, Space};
use serde_json::{Value, json};

use crate::support::{data, random_field};

fn job() -> Job {
    Job::new(Limits { max_bytes: 1 << 29, max_side: 1 << 15 })
}

/// A folder in memory.
type Files = BTreeMap<String, Vec<u8>>;

fn on_disk(folder: &Path) -> Files {
    let mut files = Files::new();
    let mut open = vec![folder.to_path_buf()];
    while let Some(at) = open.pop() {
        for entry in std::fs::read_dir(at).unwrap().map(|entry| entry.unwrap().path()) {
            match entry.is_dir() {
                true => open.push(entry),
                false => {
                    let name = entry.strip_prefix(folder).unwrap().to_string_lossy().into_owned();
                    files.insert(name, std::fs::read(&entry).unwrap());
                }
            }
        }
    }
    files
}

fn to_disk(files: &Files) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in files {
        let path = folder.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, bytes).unwrap();
    }
    folder
}

fn read(folder: &Path) -> ReflectanceField {
    open(folder, &job()).unwrap().into_field().unwrap().field
}

/// A folder taken apart.
struct Web {
    info: Value,
    /// The three channels of each picture, texel by texel.
    pictures: Vec<Vec<[f64; 3]>>,
    width: usize,
}

fn jpeg(bytes: &[u8]) -> (usize, Vec<[f64; 3]>) {
    let image = image::load_from_memory_with_format(bytes, image::ImageFormat::Jpeg).unwrap().to_rgb8();
    (image.width() as usize, image.pixels().map(|p| p.0.map(|b| f64::from(b) / 255.0)).collect())
}

impl Web {
    fn of(files: &Files) -> Self {
        let info: Value = serde_json::from_slice(&files["info.json"]).unwrap();
        let width = info["width"].as_u64().unwrap() as usize;
        let height = info["height"].as_u64().unwrap() as usize;
        let count = match info["yccplanes"].as_array() {
            Some(parts) => parts.iter().map(|n| n.as_u64().unwrap()).sum::<u64>(),
            None => info["nplanes"].as_u64().unwrap(),
        };
        let picture = |k: usize| picture(files, k, width, height);
        Self { pictures: (0..count.div_ceil(3) as usize).map(picture).collect(), info, width }
    }

    fn number(&self, list: &str, k: usize) -> f64 {
        self.info["materials"][0][list][k].as_f64().unwrap()
    }

    /// Coefficient `k` of the folder at a texel.
    fn coefficient(&self, k: usize, x: usize, y: usize) -> f64 {
        let texture = self.pictures[k / 3][y * self.width + x][k % 3];
        (texture - self.number("bias", k)) * self.number("scale", k)
    }

    fn functions(&self, light: Direction) -> Vec<f64> {
        let [x, y, z] = light.to_array();
        match self.info["type"].as_str().unwrap() {
            "ptm" => vec![1.0, x, y, x * x, x * y, y * y],
            "hsh" => {
                let (p, c) = (y.atan2(x), z);
                let s = (c - c * c).sqrt();
                let (a, b) = ((6.0 / PI).sqrt(), (30.0 / PI).sqrt());
                vec![
                    1.0 / (2.0 * PI).sqrt(),
                    a * p.cos() * s,
                    (3.0 / (2.0 * PI)).sqrt() * (2.0 * c - 1.0),
                    a * p.sin() * s,
                    b * (2.0 * p).cos() * (c * c - c),
                    b * p.cos() * (2.0 * c - 1.0) * s,
                    (5.0 / (2.0 * PI)).sqrt() * (1.0 - 6.0 * c + 6.0 * c * c),
                    b * (2.0 * c - 1.0) * s * p.sin(),
                    b * (c * c - c) * (2.0 * p).sin(),
                ]
            }
            other => panic!("type {other}"),
        }
    }

    fn relit(&self, x: usize, y: usize, channel: usize, light: Direction) -> f64 {
        let functions = self.functions(light);
        match self.info["colorspace"].as_str().unwrap() {
            "rgb" => {
                functions.iter().enumerate().map(|(k, f)| f * self.coefficient(3 * k + channel, x, y)).sum()
            }
            "lrgb" => {
                let luminance: f64 =
                    functions.iter().enumerate().map(|(k, f)| f * self.coefficient(3 + k, x, y)).sum();
                luminance * self.coefficient(channel, x, y)
            }
            other => panic!("colours {other}"),
        }
    }
}

/// Picture `k`, whole or from the tiles of the finest level.
fn picture(files: &Files, k: usize, width: usize, height: usize) -> Vec<[f64; 3]> {
    if let Some(bytes) = files.get(&format!("plane_{k}.jpg")) {
        return jpeg(bytes).1;
    }
    let (across, down) = (width.div_ceil(256), height.div_ceil(256));
    let levels = {
        let mut levels = vec![(width, height)];
        while levels.last().unwrap().0.max(levels.last().unwrap().1) > 256 {
            let (w, h) = *levels.last().unwrap();
            levels.push((w >> 1, h >> 1));
        }
        levels
    };
    let tile = |x: usize, y: usize| -> Vec<u8> {
        if files.contains_key("plane_0.dzi") {
            return files[&format!("plane_{k}_files/{}/{x}_{y}.jpg", levels.len() - 1)].clone();
        }
        let interleaved = files.contains_key("planes.tzi");
        let name = if interleaved { "planes".to_owned() } else { format!("plane_{k}") };
        let index: Value = serde_json::from_slice(&files[&format!("{name}.tzi")]).unwrap();
        assert_eq!(index["nlevels"].as_u64().unwrap() as usize, levels.len());
        let coarser: usize = levels[1..].iter().map(|(w, h)| w.div_ceil(256) * h.div_ceil(256)).sum();
        let mut at = coarser + y * across + x;
        if interleaved {
            at = at * index["stride"].as_u64().unwrap() as usize + k;
        }
        let offset = |at: usize| index["offsets"][at].as_u64().unwrap() as usize;
        files[&format!("{name}.tzb")][offset(at)..offset(at + 1)].to_vec()
    };
    let mut out = vec![[0.0; 3]; width * height];
    for (x, y) in (0..down).flat_map(|y| (0..across).map(move |x| (x, y))) {
        let (w, texels) = jpeg(&tile(x, y));
        assert_eq!(w, (width - 256 * x).min(256));
        for (i, texel) in texels.into_iter().enumerate() {
            out[(256 * y + i / w) * width + 256 * x + i % w] = texel;
        }
    }
    out
}

fn lights() -> [Direction; 3] {
    [[0.1, 0.2], [0.6, -0.3], [-0.4, 0.5]].map(|[u, v]| Direction::from_disk(u, v))
}

fn assert_read_alike(files: &Files, field: &ReflectanceField, every: usize) {
    let web = Web::of(files);
    for texel in (0..field.size().texels()).step_by(every) {
        let (x, y) = (texel % field.size().width, texel / field.size().width);
        for light in lights() {
            for (channel, ours) in field.value(x, y, light).into_iter().enumerate() {
                let truth = web.relit(x, y, channel, light);
                assert!(
                    (f64::from(ours) - truth).abs() < 1e-4 * (1.0 + truth.abs()),
                    "({x}, {y}): {ours}, {truth}"
                );
            }
        }
    }
}

#[test]
fn the_coins_of_openlime_are_read_alike() {
    for name in ["rti-web/coin-ptm", "rti-web/coin-hsh-deepzoom"] {
        let Some(folder) = data(name) else { return };
        let opened = open(&folder, &job()).unwrap();
        assert_eq!(opened.content(), Content::Field);
        let field = opened.into_field().unwrap().field;
        assert_eq!((field.size(), field.lights().len()), (Size::new(1024, 1024), 116));
        assert_read_alike(&on_disk(&folder), &field, 40_009);
    }
}

/// A smooth field, since JPEG blurs noise.
fn smooth(basis: &Basis, layout: &PlaneLayout, size: Size) -> ReflectanceField {
    let flat = random_field(basis.clone(), layout.clone(), Space::Srgb, Size::new(1, 1), 4);
    let mut planes = relume::Planes::zeros(size, layout.planes(basis.len()));
    for (k, plane) in planes.iter_mut().enumerate() {
        let base = flat.coefficients().at(k, 0, 0).abs();
        for (i, value) in plane.iter_mut().enumerate() {
            let (x, y) = ((i % size.width) as f32, (i / size.width) as f32);
            let wave = (0.05 * x + k as f32).sin() * (0.04 * y).cos();
            *value =
                if k < basis.len() * layout.functions() { 0.3 * wave + 0.2 * base } else { 0.6 + 0.3 * wave };
        }
    }
    ReflectanceField::new(basis.clone(), layout.clone(), Space::Srgb, planes).unwrap()
}

fn written(field: &ReflectanceField, layout: WebLayout) -> Files {
    let mut files = Files::new();
    let options = WebOptions { layout, quality: 98 };
    let mut store = |name: &str, bytes: &[u8]| {
        files.insert(name.to_owned(), bytes.to_vec());
        Ok(())
    };
    encode_web(field, &options, &job(), &mut store).unwrap();
    files
}

#[test]
fn folders_of_every_layout_are_read_by_the_other_decoder_and_alike() {
    let hsh9 = Basis::from_name("hsh9").unwrap();
    for (layout, size) in WebLayout::ALL.iter().zip([(60, 40), (300, 270), (520, 130), (257, 600)]) {
        for (basis, color) in [(&Basis::Ptm, PlaneLayout::RGB), (&hsh9, PlaneLayout::LRGB)] {
            let field = smooth(basis, &color, Size::new(size.0, size.1));
            let files = written(&field, *layout);
            let disk = to_disk(&files);
            let again = read(disk.path());
            assert_eq!((again.basis(), again.layout(), again.space()), (basis, &color, Space::Srgb));
            assert_read_alike(&files, &again, 977);
            let web = Web::of(&files);
            for (x, y) in [(0, 0), (size.0 - 1, 0), (0, size.1 - 1), (size.0 / 2, size.1 / 2)] {
                for (c, truth) in field.value(x, y, lights()[1]).into_iter().enumerate() {
                    let found = web.relit(x, y, c, lights()[1]);
                    assert!((found - f64::from(truth)).abs() < 0.03, "{layout:?}: {found} against {truth}");
                }
            }
        }
    }
}

#[test]
fn the_coarsest_level_is_one_whole_tile() {
    let field = smooth(&Basis::Ptm, &PlaneLayout::LRGB, Size::new(700, 300));
    let files = written(&field, WebLayout::Deepzoom);
    let (width, texels) = jpeg(&files["plane_0_files/0/0_0.jpg"]);
    assert_eq!((width, texels.len() / width), (175, 75));
    assert!(!files.contains_key("plane_0_files/0/1_0.jpg") && !files.contains_key("plane_0_files/3/0_0.jpg"));
    // The middle of the colour is the same on both.
    let whole = picture(&files, 0, 700, 300)[150 * 700 + 352];
    let coarse = texels[37 * 175 + 88];
    assert!((0..3).all(|c| (whole[c] - coarse[c]).abs() < 0.03), "{whole:?} {coarse:?}");
}

/// Tables of random colours, of a type and colours, as the format stores them.
fn table_folder(kind: &str, colors: &str) -> (Files, Value) {
    let mut random = Stream::new(12, Purpose::Sample, [0]);
    let (planes, width, height) = (6, 20, 12);
    let lights: Vec<[f64; 3]> = (0..14)
        .map(|i| Direction::from_angles(0.2 + 0.08 * f64::from(i), 2.4 * f64::from(i)).to_array())
        .collect();
    let entries = if kind == "rbf" { 14 } else { 36 };
    let basis: Vec<u64> = (0..(planes + 1) * entries * 3).map(|_| random.below(256) as u64).collect();
    let scale: Vec<f64> = (0..planes).map(|k| 0.5 + 0.1 * k as f64).collect();
    let bias: Vec<f64> = (0..planes).map(|k| 0.3 + 0.05 * k as f64).collect();
    let range: Vec<f64> = (0..planes).map(|k| 120.0 + 30.0 * k as f64).collect();
    let mut info = json!({
        "width": width, "height": height, "format": "jpg", "type": kind, "colorspace": colors, "nplanes": planes,
        "lights": lights.concat(), "sigma": 0.35, "resolution": 6, "basis": basis, "quality": 95,
        "materials": [{ "scale": scale, "bias": bias, "range": range }],
    });
    if colors == "mycc" {
        info["yccplanes"] = json!([4, 1, 1]);
        info.as_object_mut().unwrap().remove("nplanes");
    }
    let mut files = Files::from([("info.json".to_owned(), info.to_string().into_bytes())]);
    for k in 0..2 {
        let samples: Vec<u8> =
            (0..width * height * 3).map(|i| (40 + 13 * k + i / 3 % width * 8 + i % 3 * 20) as u8).collect();
        let mut out = Vec::new();
        image::codecs::jpeg::JpegEncoder::new_with_quality(&mut out, 95)
            .encode(&samples, width as u32, height as u32, image::ExtendedColorType::Rgb8)
            .unwrap();
        files.insert(format!("plane_{k}.jpg"), out);
    }
    (files, info)
}

/// The share of each entry of the tables under a light, by the formulas of the format.
fn table_shares(info: &Value, light: Direction) -> Vec<f64> {
    let [x, y, z] = light.to_array();
    if info["type"] == "rbf" {
        let sigma = info["sigma"].as_f64().unwrap();
        let list: Vec<f64> = info["lights"].as_array().unwrap().iter().map(|n| n.as_f64().unwrap()).collect();
        let mut weights: Vec<f64> = list
            .chunks(3)
            .map(|l| (-((l[0] - x).powi(2) + (l[1] - y).powi(2) + (l[2] - z).powi(2)) / sigma.powi(2)).exp())
            .collect();
        for threshold in [0.0, 0.001] {
            let total: f64 = weights.iter().sum();
            weights.iter_mut().for_each(|w| *w = if *w / total > threshold { *w / total } else { 0.0 });
        }
        let total: f64 = weights.iter().sum();
        return weights.iter().map(|w| w / total).collect();
    }
    let s = x.abs() + y.abs() + z.abs();
    let (across, down) = (((x + y) / s + 1.0) / 2.0 * 5.0, ((y - x) / s + 1.0) / 2.0 * 5.0);
    let (i, k) = ((across.floor() as usize).min(4), (down.floor() as usize).min(4));
    let (dx, dy) = (across - i as f64, down - k as f64);
    let mut shares = vec![0.0; 36];
    for (di, dk, share) in
        [(0, 0, (1.0 - dx) * (1.0 - dy)), (1, 0, dx * (1.0 - dy)), (0, 1, (1.0 - dx) * dy), (1, 1, dx * dy)]
    {
        shares[i + di + (k + dk) * 6] += share;
    }
    shares
}

fn table_truth(files: &Files, info: &Value, x: usize, y: usize, light: Direction) -> [f64; 3] {
    let shares = table_shares(info, light);
    let entries = shares.len();
    let number = |list: &str, k: usize| info["materials"][0][list][k].as_f64().unwrap();
    let table = |p: usize, c: usize| -> f64 {
        (0..entries)
            .map(|l| {
                let byte = info["basis"][(p * entries + l) * 3 + c].as_f64().unwrap();
                let value = if p == 0 { byte / 255.0 } else { (byte - 127.0) / number("range", p - 1) };
                shares[l] * value
            })
            .sum()
    };
    let mut color = [table(0, 0), table(0, 1), table(0, 2)];
    for k in 0..6 {
        let texture = jpeg(&files[&format!("plane_{}.jpg", k / 3)]).1[y * 20 + x][k % 3];
        let r = (texture - number("bias", k)) * number("scale", k);
        match info["colorspace"].as_str().unwrap() {
            "mrgb" => (0..3).for_each(|c| color[c] += table(k + 1, c) * r),
            // One picture of triples, one of luma.
            _ if k < 3 => color[k] += table(k + 1, k) * r,
            _ => color[0] += table(k + 1, 0) * r,
        }
    }
    if info["colorspace"] == "mrgb" {
        return color;
    }
    let [luma, first, second] = color;
    let (green, blue) = (luma + second / 2.0, luma - second / 2.0 - first / 2.0);
    [blue + first, green, blue]
}

#[test]
fn tables_of_principal_components_are_read_by_their_formulas() {
    for (kind, colors) in [("rbf", "mrgb"), ("bilinear", "mrgb"), ("bilinear", "mycc"), ("rbf", "mycc")] {
        let (files, info) = table_folder(kind, colors);
        let field = read(to_disk(&files).path());
        let mut squares = 0.0;
        let all: Vec<Direction> =
            (0..40).map(|i| Direction::from_angles(0.03 * f64::from(i), 2.1 * f64::from(i))).collect();
        for &light in &all {
            for (x, y) in [(0, 0), (19, 0), (7, 11)] {
                let truth = table_truth(&files, &info, x, y, light);
                for (c, ours) in field.value(x, y, light).into_iter().enumerate() {
                    squares += (f64::from(ours) - truth[c]).powi(2);
                }
            }
        }
        let rms = (squares / (all.len() * 9) as f64).sqrt();
        // Functions are interpolated between directions four degrees apart: tables of noise are the worst case.
        assert!(rms < 0.02, "{kind} {colors}: {rms}");
    }
}

#[test]
fn a_neural_folder_is_refused_by_name_and_others_say_what_is_wrong() {
    let field = smooth(&Basis::Ptm, &PlaneLayout::RGB, Size::new(40, 30));
    let files = written(&field, WebLayout::Plain);
    let changed = |from: &str, to: &str| {
        let mut files = files.clone();
        let text = String::from_utf8(files["info.json"].clone()).unwrap();
        assert!(text.contains(from), "{from}");
        files.insert("info.json".to_owned(), text.replace(from, to).into_bytes());
        open(to_disk(&files).path(), &job()).unwrap().into_field().unwrap_err()
    };
    for (from, to, word) in [
        ("\"ptm\"", "\"neural\"", "neural"),
        ("\"ptm\"", "\"dmd\"", "dmd"),
        ("\"rgb\"", "\"ycc\"", "ycc"),
        ("\"jpg\"", "\"png\"", "png"),
        ("\"nplanes\": 18", "\"nplanes\": 21", "'scale'"),
        ("\"width\": 40", "\"width\": 41", "plane_0.jpg has 40 x 30"),
        ("\"width\": 40", "\"width\": -1", "'width'"),
    ] {
        let error = changed(from, to);
        assert!(matches!(error.kind(), ErrorKind::Unsupported | ErrorKind::Invalid), "{error}");
        assert!(error.message().contains(word), "{error}");
    }
    let mut incomplete = files.clone();
    incomplete.remove("plane_3.jpg");
    let error = open(to_disk(&incomplete).path(), &job()).unwrap().into_field().unwrap_err();
    assert!(error.message().contains("plane_3.jpg"), "{error}");
}

/// The usual converter writes scales of zero.
#[test]
fn a_folder_becomes_a_texture_map_with_scales() {
    let field = smooth(&Basis::Ptm, &PlaneLayout::RGB, Size::new(40, 30));
    let read = read(to_disk(&written(&field, WebLayout::Plain)).path());
    let file = encode_field(&read, FieldFormat::Ptm, None, &job()).unwrap();
    let text = String::from_utf8_lossy(&file[..200]).into_owned();
    let scales: Vec<f64> = text.lines().nth(4).unwrap().split(' ').map(|n| n.parse().unwrap()).collect();
    assert!(scales.len() == 6 && scales.iter().all(|scale| *scale != 0.0), "{scales:?}");
    assert_near(&read, &decode_field(&file, &job()).unwrap().field, 0.02);
}

/// The usual converter takes the scale of red for all channels.
#[test]
fn a_folder_becomes_rti_with_the_scales_of_all_channels() {
    let hsh9 = Basis::from_name("hsh9").unwrap();
    let mut field = smooth(&hsh9, &PlaneLayout::RGB, Size::new(40, 30));
    let mut planes = field.coefficients().clone();
    let texels = planes.size().texels();
    // Green and blue vary more, and about other values.
    planes.as_mut_slice()[9 * texels..].iter_mut().for_each(|v| *v = 2.5 * *v - 0.3);
    field = field.with_coefficients(planes).unwrap();
    let read = read(to_disk(&written(&field, WebLayout::Plain)).path());
    assert_near(&field, &read, 0.06);
    let file = encode_field(&read, FieldFormat::Rti, None, &job()).unwrap();
    assert_near(&read, &decode_field(&file, &job()).unwrap().field, 0.04);
}

/// The usual converter refuses it.
#[test]
fn the_tablet_of_hp_labs_becomes_a_folder() {
    let Some(path) = data("ptm/tablet1.ptm") else { return };
    let field = decode_field(&std::fs::read(path).unwrap(), &job()).unwrap().field;
    let again = read(to_disk(&written(&field, WebLayout::Plain)).path());
    assert_eq!((again.basis(), again.layout(), again.size()), (field.basis(), field.layout(), field.size()));
    let mut squares = 0.0;
    for texel in (0..512 * 512).step_by(1009) {
        for (a, b) in field.value(texel % 512, texel / 512, lights()[0]).into_iter().zip(again.value(
            texel % 512,
            texel / 512,
            lights()[0],
        )) {
            squares += f64::from(a - b).powi(2);
        }
    }
    let rms = (squares / (3.0 * 260.0)).sqrt();
    assert!(rms < 0.03, "{rms}");
}

fn assert_near(a: &ReflectanceField, b: &ReflectanceField, tolerance: f32) {
    for (x, y, light) in [(0, 0, 0), (39, 0, 1), (0, 29, 2), (20, 15, 1)] {
        for (a, b) in a.value(x, y, lights()[light]).into_iter().zip(b.value(x, y, lights()[light])) {
            assert!((a - b).abs() < tolerance, "({x}, {y}): {a} against {b}");
        }
    }
}

#[test]
fn textures_that_viewers_do_not_show_are_refused_and_converted() {
    let linear = random_field(Basis::Ptm, PlaneLayout::RGB, Space::Linear, Size::new(8, 8), 3);
    let mut store = |_: &str, _: &[u8]| Ok(());
    let error = encode_web(&linear, &WebOptions::default(), &job(), &mut store).unwrap_err();
    assert!(error.message().contains("linear"), "{error}");
    let picture = random_field(Basis::Constant, PlaneLayout::RGB, Space::Srgb, Size::new(8, 8), 3);
    let error = encode_web(&picture, &WebOptions::default(), &job(), &mut store).unwrap_err();
    assert!(error.message().contains("relume convert"), "{error}");
    let options =
        ConvertOptions { basis: Some(Basis::Ptm), space: Some(Space::Srgb), ..ConvertOptions::default() };
    let made = convert(&linear, &options, &job()).unwrap();
    encode_web(&made, &WebOptions::default(), &job(), &mut store).unwrap();
}

/// Every one of 10,000 changed folders gives a field or one sentence.
#[test]
fn changed_folders_never_panic() {
    let field = smooth(&Basis::Ptm, &PlaneLayout::LRGB, Size::new(9, 6));
    let hsh9 = Basis::from_name("hsh9").unwrap();
    let tables = [table_folder("rbf", "mrgb").0, table_folder("bilinear", "mycc").0];
    let made = WebLayout::ALL.iter().map(|layout| written(&field, *layout));
    let folders: Vec<Files> = made
        .chain([written(&smooth(&hsh9, &PlaneLayout::RGB, Size::new(9, 6)), WebLayout::Plain)])
        .chain(tables)
        .collect();
    let mut random = Stream::new(90, Purpose::Sample, [0]);
    for round in 0..10_000 {
        let files = &folders[round % folders.len()];
        // Tables take long to make orthonormal: their heads are changed less often.
        if round % folders.len() >= 6 && round % 8 != 0 {
            continue;
        }
        let mut files = files.clone();
        let names: Vec<String> = files.keys().filter(|name| !name.ends_with("jpg")).cloned().collect();
        let all: Vec<String> = files.keys().cloned().collect();
        let name = if random.below(4) == 0 {
            &all[random.below(all.len())]
        } else {
            &names[random.below(names.len())]
        };
        let bytes = files.get_mut(name).unwrap();
        for _ in 0..=random.below(3) {
            let at = random.below(bytes.len());
            match random.below(4) {
                0 => bytes[at] ^= 1 << random.below(8),
                1 => bytes[at] = b"0129-.\"]}{"[random.below(10)],
                2 => bytes.truncate(at.max(1)),
                _ => bytes[at] = random.below(256) as u8,
            }
        }
        let read = |name: &str| Ok(files.get(name).cloned());
        let outcome =
            std::panic::catch_unwind(|| relume::format::web::decode_files(&read, &crate::support::job()));
        let result = outcome.unwrap_or_else(|_| panic!("round {round}: {name}"));
        if let Err(error) = result {
            let message = error.message();
            assert!(!message.is_empty() && message.len() < 500 && !message.contains('\n'), "{message}");
        }
    }
}
