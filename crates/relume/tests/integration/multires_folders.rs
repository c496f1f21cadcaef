//! Folders of the older web RTI viewer (`info.xml`), by an independent writer and an independent decoder, both from the
//! description in `docs/formats.md` alone.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use relume::field::{Basis, PlaneLayout};
use relume::format::web::{WebLayout, WebOptions, decode_files, encode_web};
use relume::format::{Content, Encoding, FieldFormat, decode_field, encode_field, open};
use relume::numeric::random::{Purpose, Stream};
use relume::{Direction, ErrorKind, Job, Limits, ReflectanceField, Size, Space};

type Files = BTreeMap<String, Vec<u8>>;

fn job() -> Job {
    Job::new(Limits { max_bytes: 1 << 29, max_side: 1 << 15 })
}

fn to_disk(files: &Files) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in files {
        std::fs::write(folder.path().join(name), bytes).unwrap();
    }
    folder
}

fn read(files: &Files) -> relume::Result<ReflectanceField> {
    decode_files(&|name| Ok(files.get(name).cloned()), &job())
}

// The writer: bytes of pictures, exact in PNG tiles.

/// A folder in the making: so many pictures of interleaved bytes.
struct Folder {
    kind: &'static str,
    width: usize,
    height: usize,
    terms: usize,
    scale: Vec<f64>,
    bias: Vec<f64>,
    tile: usize,
    pictures: Vec<Vec<[u8; 3]>>,
}

fn random_folder(kind: &'static str, terms: usize, (width, height): (usize, usize), tile: usize) -> Folder {
    let mut random = Stream::new(31, Purpose::Sample, [width as u64]);
    let count = if kind == "LRGB_PTM" { 3 } else { terms };
    let mut texel = || [0; 3].map(|_| random.below(256) as u8);
    let pictures = (0..count).map(|_| (0..width * height).map(|_| texel()).collect()).collect();
    let scale = (0..terms).map(|k| 0.5 + 0.25 * k as f64).collect();
    let bias = (0..terms).map(|k| (20 * k) as f64).collect();
    Folder { kind, width, height, terms, scale, bias, tile, pictures }
}

impl Folder {
    fn square(&self) -> usize {
        let mut square = self.tile;
        while square < self.width.max(self.height) {
            square *= 2;
        }
        square
    }

    fn texel(&self, k: usize, x: i64, y: i64) -> [u8; 3] {
        let inside = (0..self.width as i64).contains(&x) && (0..self.height as i64).contains(&y);
        if inside { self.pictures[k][y as usize * self.width + x as usize] } else { [0; 3] }
    }

    /// Splits a node, the upper left corner of which is (x, y), down to the finest level, and stores that.
    fn split(&self, index: usize, x: i64, y: i64, side: usize, out: &mut Files) {
        if side > self.tile {
            let half = side as i64 / 2;
            for (child, (dx, dy)) in [(0, 0), (half, 0), (0, half), (half, half)].into_iter().enumerate() {
                self.split(4 * index + 1 + child, x + dx, y + dy, side / 2, out);
            }
            return;
        }
        let offset = |length: usize| ((self.square() - length) / 2) as i64;
        let (left, top) = (offset(self.width), offset(self.height));
        let across = self.tile as i64 + 2;
        for k in 0..self.pictures.len() {
            let places = (0..across).flat_map(|j| (0..across).map(move |i| (i, j)));
            let texels = places.flat_map(|(i, j)| self.texel(k, x + i - 1 - left, y + j - 1 - top));
            let tile = image::RgbImage::from_raw(across as u32, across as u32, texels.collect()).unwrap();
            let mut png = std::io::Cursor::new(Vec::new());
            tile.write_to(&mut png, image::ImageFormat::Png).unwrap();
            out.insert(format!("{}_{}.png", index + 1, k + 1), png.into_inner());
        }
    }

    fn files(&self, listing: &str) -> Files {
        let list = |numbers: &[f64]| numbers.iter().map(|n| format!("{n} ")).collect::<String>();
        let (square, nodes) = (self.square(), listing.lines().count().max(1));
        let head = format!(
            "<!DOCTYPE WebMultiRes>\n<MultiRes format=\"1\">\n <Content type=\"{}\">\n  <Size height=\"{}\" \
             width=\"{}\" coefficients=\"{}\"/>\n  <Scale>{}</Scale>\n  <Bias>{}</Bias>\n </Content>\n <Tree>{nodes} 0\n\
             {}\n{square} {square} 255\n0 0 0\n{listing}</Tree>\n</MultiRes>\n",
            self.kind,
            self.height,
            self.width,
            self.terms,
            list(&self.scale),
            list(&self.bias),
            self.tile,
        );
        let mut files = Files::from([("info.xml".to_owned(), head.into_bytes())]);
        self.split(0, 0, 0, square, &mut files);
        files
    }

    fn relit(&self, x: usize, y: usize, light: Direction) -> [f64; 3] {
        let functions = functions(self.kind, self.terms, light);
        let byte = |k: usize, c: usize| f64::from(self.pictures[k][y * self.width + x][c]);
        match self.kind {
            "LRGB_PTM" => {
                let lum: f64 = (0..6)
                    .map(|k| (byte(k / 3, k % 3) - self.bias[k]) * self.scale[k] / 255.0 * functions[k])
                    .sum();
                [0, 1, 2].map(|c| lum * byte(2, c) / 255.0)
            }
            "RGB_PTM" => [0, 1, 2].map(|c| {
                (0..6).map(|k| (byte(k, c) - self.bias[k]) * self.scale[k] / 255.0 * functions[k]).sum()
            }),
            "HSH_RTI" => [0, 1, 2].map(|c| {
                let terms = 0..self.terms;
                terms.map(|k| (byte(k, c) / 255.0 * self.bias[k] + self.scale[k]) * functions[k]).sum()
            }),
            _ => [0, 1, 2].map(|c| byte(0, c) / 255.0),
        }
    }
}

fn functions(kind: &str, terms: usize, light: Direction) -> Vec<f64> {
    let [x, y, z] = light.to_array();
    if kind != "HSH_RTI" {
        return vec![x * x, y * y, x * y, x, y, 1.0];
    }
    let (p, c) = (y.atan2(x), z);
    let s = (c - c * c).sqrt();
    let (a, b) = ((6.0 / PI).sqrt(), (30.0 / PI).sqrt());
    let all = [
        1.0 / (2.0 * PI).sqrt(),
        a * p.cos() * s,
        (3.0 / (2.0 * PI)).sqrt() * (2.0 * c - 1.0),
        a * p.sin() * s,
        b * (2.0 * p).cos() * (c * c - c),
        b * p.cos() * (2.0 * c - 1.0) * s,
        (5.0 / (2.0 * PI)).sqrt() * (1.0 - 6.0 * c + 6.0 * c * c),
        b * (2.0 * c - 1.0) * s * p.sin(),
        b * (c * c - c) * (2.0 * p).sin(),
    ];
    all[..terms].to_vec()
}

fn lights() -> [Direction; 3] {
    [[0.1, 0.2], [0.6, -0.3], [-0.4, 0.5]].map(|[u, v]| Direction::from_disk(u, v))
}

#[test]
fn folders_of_the_other_writer_are_read_texel_by_texel() {
    let cases = [
        ("LRGB_PTM", 6, (70, 41), 16),
        ("RGB_PTM", 6, (33, 64), 32),
        ("HSH_RTI", 9, (40, 40), 16),
        ("HSH_RTI", 4, (5, 9), 16),
        ("IMAGE", 1, (20, 37), 16),
    ];
    for (kind, terms, size, tile) in cases {
        let folder = random_folder(kind, terms, size, tile);
        let disk = to_disk(&folder.files(""));
        let opened = open(disk.path(), &job()).unwrap();
        assert_eq!(opened.content(), Content::Field);
        let file = opened.into_field().unwrap();
        let field = file.field;
        assert_eq!((field.size(), field.space()), (Size::new(size.0, size.1), Space::Srgb));
        for texel in 0..size.0 * size.1 {
            let (x, y) = (texel % size.0, texel / size.0);
            let truth = folder.relit(x, y, lights()[texel % 3]);
            for (ours, truth) in field.value(x, y, lights()[texel % 3]).into_iter().zip(truth) {
                assert!(
                    (f64::from(ours) - truth).abs() < 2e-5 * (1.0 + truth.abs()),
                    "{kind} ({x}, {y}): {ours} {truth}"
                );
            }
        }
        if let Encoding::Ptm(encoding) = file.encoding {
            // A copy as .ptm has the bytes of the tiles.
            let copy = encode_field(&field, FieldFormat::Ptm, Some(&file.encoding), &job()).unwrap();
            assert_eq!(f64::from(encoding.bias[3]), folder.bias[3]);
            // Texel (0, 0) comes first of the last row, since rows run from the bottom.
            let colors = if kind == "LRGB_PTM" { 3 * size.0 * size.1 } else { 12 * size.0 * size.1 };
            let at = copy.len() - colors - 6 * size.0;
            assert_eq!(copy[at], folder.pictures[0][0][0]);
        }
    }
}

#[test]
fn older_folders_list_their_nodes_in_any_order() {
    let folder = random_folder("LRGB_PTM", 6, (30, 27), 16);
    let mut files = folder.files(
        "1 -1 1 2 3 4 16 1 0 0 0 1 1 1\n2 0 -1 -1 -1 -1 16 1 0 0 0 0.5 0.5 1\n3 0 -1 -1 -1 -1 16 1 0.5 0 0 1 0.5 1\n\
         4 0 -1 -1 -1 -1 16 1 0 0.5 0 0.5 1 1\n5 0 -1 -1 -1 -1 16 1 0.5 0.5 0 1 1 1\n",
    );
    // There the lower row comes first.
    for k in 1..=3 {
        for (lower, upper) in [(2, 4), (3, 5)] {
            let [a, b] = [lower, upper].map(|n| files[&format!("{n}_{k}.png")].clone());
            files.insert(format!("{lower}_{k}.png"), b);
            files.insert(format!("{upper}_{k}.png"), a);
        }
    }
    let field = read(&files).unwrap();
    for (x, y) in [(0, 0), (29, 0), (3, 26), (29, 26), (15, 13)] {
        let truth = folder.relit(x, y, lights()[1]);
        for (ours, truth) in field.value(x, y, lights()[1]).into_iter().zip(truth) {
            assert!((f64::from(ours) - truth).abs() < 1e-4, "({x}, {y})");
        }
    }
}

// The decoder of written folders: it walks the tree from its root, as the viewer does.

struct Written {
    files: Files,
    kind: String,
    width: usize,
    height: usize,
    scale: Vec<f64>,
    bias: Vec<f64>,
    square: f64,
    nodes: Vec<Vec<f64>>,
}

fn between<'a>(text: &'a str, before: &str, after: &str) -> &'a str {
    text.split_once(before).unwrap().1.split_once(after).unwrap().0
}

impl Written {
    fn of(field: &ReflectanceField) -> Self {
        let mut files = Files::new();
        let options = WebOptions { layout: WebLayout::Multires, quality: 98 };
        let mut store = |name: &str, bytes: &[u8]| {
            assert!(files.insert(name.to_owned(), bytes.to_vec()).is_none(), "{name}");
            Ok(())
        };
        encode_web(field, &options, &job(), &mut store).unwrap();
        let text = String::from_utf8(files["info.xml"].clone()).unwrap();
        let numbers = |text: &str| text.split_whitespace().map(|n| n.parse().unwrap()).collect::<Vec<f64>>();
        let tree: Vec<&str> = between(&text, "<Tree>", "</Tree>").lines().collect();
        let nodes: Vec<Vec<f64>> = tree[4..].iter().map(|line| numbers(line)).collect();
        assert_eq!(numbers(tree[0]), [nodes.len() as f64, 0.0]);
        assert_eq!((tree[1], tree[3]), ("256", "0 0 0"));
        Self {
            kind: between(&text, "Content type=\"", "\"").to_owned(),
            width: between(&text, " width=\"", "\"").parse().unwrap(),
            height: between(&text, " height=\"", "\"").parse().unwrap(),
            scale: numbers(between(&text, "<Scale>", "</Scale>")),
            bias: numbers(between(&text, "<Bias>", "</Bias>")),
            square: numbers(tree[2])[0],
            nodes,
            files,
        }
    }

    /// The finest node at a place of the square, in units of its side, y up; and the levels above it.
    fn node(&self, x: f64, y: f64) -> (&[f64], usize) {
        let (mut at, mut depth) = (0, 0);
        loop {
            let node = &self.nodes[at];
            assert!(
                node[8] <= x && x <= node[11] && node[9] <= y && y <= node[12],
                "{node:?} without ({x}, {y})"
            );
            let children = &node[2..6];
            if children[0] < 0.0 {
                return (node, depth);
            }
            let (right, up) = (x > (node[8] + node[11]) / 2.0, y > (node[9] + node[12]) / 2.0);
            at = children[usize::from(right) + 2 * usize::from(up)] as usize;
            assert_eq!(self.nodes[at][1] as usize, (self.nodes[at][0] as usize - 2) / 4);
            depth += 1;
        }
    }

    fn texel(&self, tile: &str, x: f64, y: f64) -> [f64; 3] {
        let image = image::load_from_memory(&self.files[tile]).unwrap().to_rgb8();
        assert_eq!((image.width(), image.height()), (258, 258));
        // x and y within the tile, y up; a border of one texel.
        let (i, j) = (1.0 + (256.0 * x).floor(), 1.0 + (256.0 * (1.0 - y)).floor());
        image.get_pixel(i as u32, j as u32).0.map(f64::from)
    }

    /// The bytes of picture k at a texel, y down.
    fn bytes(&self, k: usize, x: usize, y: usize) -> [f64; 3] {
        let left = ((self.square - self.width as f64) / 2.0).floor();
        let top = ((self.square - self.height as f64) / 2.0).floor();
        let (across, up) =
            ((left + x as f64 + 0.5) / self.square, 1.0 - (top + y as f64 + 0.5) / self.square);
        let (node, _) = self.node(across, up);
        assert_eq!(node[7], 1.0);
        let side = node[11] - node[8];
        self.texel(&format!("{}_{k}.jpg", node[0]), (across - node[8]) / side, (up - node[9]) / side)
    }

    fn relit(&self, x: usize, y: usize, light: Direction) -> [f64; 3] {
        let terms = self.scale.len();
        let functions = functions(&self.kind, terms, light);
        let polynomial =
            |k: usize, byte: f64| (byte / 255.0 - self.bias[k] / 255.0) * self.scale[k] * functions[k];
        match self.kind.as_str() {
            "LRGB_PTM" => {
                let (a, b) = (self.bytes(1, x, y), self.bytes(2, x, y));
                let lum: f64 = a.iter().chain(&b).enumerate().map(|(k, byte)| polynomial(k, *byte)).sum();
                self.bytes(3, x, y).map(|c| c / 255.0 * lum)
            }
            "RGB_PTM" => {
                let all: Vec<[f64; 3]> = (1..=terms).map(|k| self.bytes(k, x, y)).collect();
                [0, 1, 2].map(|c| (0..terms).map(|k| polynomial(k, all[k][c])).sum())
            }
            "HSH_RTI" => {
                let all: Vec<[f64; 3]> = (1..=terms).map(|k| self.bytes(k, x, y)).collect();
                let value =
                    |k: usize, byte: f64| (byte / 255.0 * self.bias[k] + self.scale[k]) * functions[k];
                [0, 1, 2].map(|c| (0..terms).map(|k| value(k, all[k][c])).sum())
            }
            other => panic!("{other}"),
        }
    }
}

/// A smooth field, since JPEG blurs noise.
fn smooth(basis: &Basis, layout: &PlaneLayout, size: Size) -> ReflectanceField {
    let mut planes = relume::Planes::zeros(size, layout.planes(basis.len()));
    let functions = basis.len() * layout.functions();
    for (k, plane) in planes.iter_mut().enumerate() {
        for (i, value) in plane.iter_mut().enumerate() {
            let (x, y) = ((i % size.width) as f32, (i / size.width) as f32);
            let wave = (0.05 * x + k as f32).sin() * (0.04 * y).cos();
            *value = if k < functions { 0.3 * wave + 0.1 } else { 0.6 + 0.3 * wave };
        }
    }
    ReflectanceField::new(basis.clone(), layout.clone(), Space::Srgb, planes).unwrap()
}

#[test]
fn written_folders_are_read_by_the_other_decoder_and_alike() {
    let [hsh4, hsh9] = ["hsh4", "hsh9"].map(|name| Basis::from_name(name).unwrap());
    let cases = [
        (&Basis::Ptm, PlaneLayout::LRGB, (60, 40), "LRGB_PTM"),
        (&Basis::Ptm, PlaneLayout::RGB, (300, 270), "RGB_PTM"),
        (&hsh9, PlaneLayout::RGB, (257, 600), "HSH_RTI"),
        (&hsh4, PlaneLayout::LRGB, (512, 130), "HSH_RTI"),
    ];
    for (basis, layout, size, kind) in cases {
        let field = smooth(basis, &layout, Size::new(size.0, size.1));
        let written = Written::of(&field);
        assert_eq!((written.kind.as_str(), written.width, written.height), (kind, size.0, size.1));
        let again = read(&written.files).unwrap();
        assert_eq!(again.basis(), basis);
        for (x, y) in
            [(0, 0), (size.0 - 1, 0), (0, size.1 - 1), (size.0 / 2, size.1 / 2), (size.0 - 1, size.1 / 3)]
        {
            for light in lights() {
                let (other, truth) = (written.relit(x, y, light), field.value(x, y, light));
                for ((ours, other), truth) in again.value(x, y, light).into_iter().zip(other).zip(truth) {
                    assert!((f64::from(ours) - other).abs() < 1e-4, "{kind} ({x}, {y}): {ours} {other}");
                    assert!((other - f64::from(truth)).abs() < 0.03, "{kind} ({x}, {y}): {other} {truth}");
                }
            }
        }
    }
}

#[test]
fn every_node_that_a_viewer_asks_for_has_its_files_and_no_other() {
    // The sides of the picture lie on sides of tiles: viewers take the tiles beside them for needed.
    let written = Written::of(&smooth(&Basis::Ptm, &PlaneLayout::LRGB, Size::new(512, 1000)));
    assert_eq!(written.nodes.len(), 21);
    let mut count = 1;
    for node in &written.nodes {
        let gap = |least: f64, largest: f64, length: usize| {
            let side = length as f64 / written.square;
            (0.5 * (least + largest) - 0.5).abs() <= 0.5 * (largest - least) + 0.5 * side + 1e-9
        };
        let is_needed = gap(node[8], node[11], 512) && gap(node[9], node[12], 1000);
        assert_eq!(node[7] == 1.0, is_needed, "{node:?}");
        for k in 1..=3 {
            assert_eq!(written.files.contains_key(&format!("{}_{k}.jpg", node[0])), is_needed);
        }
        count += if is_needed { 3 } else { 0 };
    }
    assert_eq!(written.files.len(), count);
    // The root shows the whole picture, half of the coefficients' resolution for each level.
    let root = written.texel("1_3.jpg", 0.5, 0.5);
    let finest = written.bytes(3, 256, 500);
    assert!((0..3).all(|c| (root[c] - finest[c]).abs() < 12.0), "{root:?} {finest:?}");
}

#[test]
fn what_the_older_viewer_does_not_show_is_refused() {
    let mut store = |_: &str, _: &[u8]| Ok(());
    let options = WebOptions { layout: WebLayout::Multires, quality: 95 };
    let sh9 = Basis::from_name("sh9").unwrap();
    let error = encode_web(&smooth(&sh9, &PlaneLayout::RGB, Size::new(9, 6)), &options, &job(), &mut store)
        .unwrap_err();
    assert!(error.message().contains("not sh9") && error.message().contains("relume convert"), "{error}");
    let linear = ReflectanceField::new(
        Basis::Ptm,
        PlaneLayout::RGB,
        Space::Linear,
        relume::Planes::zeros(Size::new(9, 6), 18),
    );
    let error = encode_web(&linear.unwrap(), &options, &job(), &mut store).unwrap_err();
    assert!(error.message().contains("linear"), "{error}");
}

#[test]
fn broken_folders_say_what_and_where() {
    let files = random_folder("RGB_PTM", 6, (33, 20), 16).files("");
    let changed = |from: &str, to: &str| {
        let mut files = files.clone();
        let text = String::from_utf8(files["info.xml"].clone()).unwrap();
        assert!(text.contains(from), "{from}");
        files.insert("info.xml".to_owned(), text.replace(from, to).into_bytes());
        read(&files).unwrap_err()
    };
    for (from, to, word) in [
        ("RGB_PTM", "DMD", "DMD"),
        ("format=\"1\"", "format=\"2\"", "format 2"),
        ("format=\"1\"", "", "_1.jpg"),
        ("coefficients=\"6\"", "coefficients=\"9\"", "9 coefficients"),
        ("width=\"33\"", "width=\"-3\"", "width"),
        ("width=\"33\"", "width=\"16777216\" x=\"", "too large, or needs more than"),
        ("<Scale>0.5", "<Scale>0", "scale 1 of 6"),
        ("<Scale>0.5", "<Scale>nan", "Scale"),
        ("</Bias>", "", "Bias"),
        ("64 64 255", "48 48 255", "48 x 48"),
        ("64 64 255", "16 16 255", "33 x 20"),
        ("0 0 0\n", "0 0 0\n1 -1 1 2 3 4\n", "14 numbers"),
        ("0 0 0\n", "0 0 0\n1 -1 -1 -1 -1 -1 16 1 0 0 0 0.25 0.25 1\n", "no tile in column"),
        ("</Tree>", "", "Tree"),
    ] {
        let error = changed(from, to);
        let known = [ErrorKind::Unsupported, ErrorKind::Invalid, ErrorKind::Limit];
        assert!(known.contains(&error.kind()), "{error}");
        let is_limit = error.kind() == ErrorKind::Limit && word.starts_with("too large");
        assert!(is_limit || error.message().contains(word), "{from} to {to}: {error}");
    }
    // The lower right child of the upper left one.
    let name = "9_4.png".to_owned();
    let mut incomplete = files.clone();
    incomplete.remove(&name);
    assert!(read(&incomplete).unwrap_err().message().contains(&name));
    let mut other = files.clone();
    other.insert(name.clone(), random_folder("RGB_PTM", 6, (5, 5), 32).files("")["1_1.png"].clone());
    let error = read(&other).unwrap_err();
    assert!(error.message().contains(&name) && error.message().contains("34 x 34"), "{error}");
}

/// Every one of 10,000 changed folders gives a field or one sentence.
#[test]
fn changed_folders_of_tiles_never_panic() {
    let listing = "1 -1 -1 -1 -1 -1 16 1 0 0 0 1 1 1\n";
    let jpegs = Written::of(&smooth(&Basis::Ptm, &PlaneLayout::LRGB, Size::new(9, 6))).files;
    let folders = [
        random_folder("LRGB_PTM", 6, (20, 9), 16).files(""),
        random_folder("RGB_PTM", 6, (9, 6), 16).files(listing),
        random_folder("HSH_RTI", 9, (9, 6), 16).files(listing),
        random_folder("IMAGE", 1, (9, 20), 16).files(""),
        jpegs,
    ];
    let mut random = Stream::new(91, Purpose::Sample, [0]);
    for round in 0..10_000 {
        // Tiles of 256 take long at this level of optimisation.
        let which = if round % 40 == 0 { 4 } else { round % 4 };
        let mut files = folders[which].clone();
        let names: Vec<String> = files.keys().cloned().collect();
        let is_tile = random.below(5) == 0;
        let name = if is_tile { names[random.below(names.len())].clone() } else { "info.xml".to_owned() };
        let bytes = files.get_mut(&name).unwrap();
        for _ in 0..=random.below(3) {
            let at = random.below(bytes.len());
            match random.below(4) {
                0 => bytes[at] ^= 1 << random.below(8),
                1 => bytes[at] = b"0129-.\"<>/ \n"[random.below(12)],
                2 => bytes.truncate(at.max(1)),
                _ => bytes[at] = random.below(256) as u8,
            }
        }
        let read = |name: &str| Ok(files.get(name).cloned());
        let outcome = std::panic::catch_unwind(|| decode_files(&read, &crate::support::job()));
        if let Err(error) = outcome.unwrap_or_else(|_| panic!("round {round}: {name}")) {
            let message = error.message();
            assert!(!message.is_empty() && message.len() < 500 && !message.contains('\n'), "{message}");
        }
    }
}

#[test]
fn the_tablet_of_hp_labs_goes_through_a_folder_of_tiles() {
    let Some(path) = crate::support::data("ptm/tablet1.ptm") else { return };
    let field = decode_field(&std::fs::read(path).unwrap(), &job()).unwrap().field;
    let again = read(&Written::of(&field).files).unwrap();
    assert_eq!((again.basis(), again.layout(), again.size()), (field.basis(), field.layout(), field.size()));
    let light = lights()[0];
    let mut squares = 0.0;
    for texel in (0..512 * 512).step_by(1009) {
        let (x, y) = (texel % 512, texel / 512);
        let both = field.value(x, y, light).into_iter().zip(again.value(x, y, light));
        squares += both.map(|(a, b)| f64::from(a - b).powi(2)).sum::<f64>();
    }
    let rms = (squares / (3.0 * 260.0)).sqrt();
    assert!(rms < 0.03, "{rms}");
}
