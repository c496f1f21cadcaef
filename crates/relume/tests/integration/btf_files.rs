//! `.btf` files written from the description of the format alone, with the values they stand for: nothing here is
//! shared with the library's reader or writer.

use half::f16;
use relume::numeric::random::{Purpose, Stream};

/// What a file of this module says before its data.
#[derive(Clone)]
pub struct Head {
    pub signature: &'static str,
    pub version: u32,
    pub cosine: u32,
    pub channels: Vec<String>,
    /// Polar angle and azimuth of each view, and those of its lights.
    pub views: Vec<([f32; 2], Vec<[f32; 2]>)>,
    pub width: u32,
    pub height: u32,
    pub rotations: u32,
}

impl Head {
    /// Three channels, and `lights` of view 0, 1 and so on.
    pub fn new(signature: &'static str, lights: &[usize], width: u32, height: u32) -> Self {
        let angles = |i: usize| [0.03 * i as f32, 0.7 * i as f32];
        let views = lights
            .iter()
            .enumerate()
            .map(|(view, &lights)| (angles(view), (0..lights).map(|light| angles(light + 1)).collect()))
            .collect();
        let channels = ["R", "G", "B"].map(str::to_owned).to_vec();
        Self { signature, version: 4, cosine: 0, channels, views, width, height, rotations: 2 }
    }

    pub fn pairs(&self) -> usize {
        self.views.iter().map(|(_, lights)| lights.len()).sum()
    }

    pub fn texels(&self) -> usize {
        (self.width * self.height) as usize
    }

    /// View and light of each pair.
    pub fn places(&self) -> Vec<(usize, usize)> {
        let of_view =
            |(view, (_, lights)): (usize, &(_, Vec<_>))| (0..lights.len()).map(move |light| (view, light));
        self.views.iter().enumerate().flat_map(of_view).collect()
    }

    /// Everything up to the width and the height, and the rotations where the signature announces them.
    pub fn bytes(&self) -> Vec<u8> {
        let mut meta = words(&[self.version]);
        meta.extend([b'x'; 240]);
        meta.extend(floats(&[10.0, 1.0, 1.0, 1.0]));
        if self.version > 1 {
            meta.extend(words(&[self.cosine]));
        }
        if self.version > 2 {
            meta.extend(words(&[7]));
            meta.extend(b"<xml />");
        }
        if self.version > 3 {
            meta.extend(words(&[self.channels.len() as u32]));
            for name in &self.channels {
                meta.extend(words(&[name.len() as u32]));
                meta.extend(name.as_bytes());
            }
        }
        let mut out = self.signature.as_bytes().to_vec();
        out.extend(words(&[meta.len() as u32 + 4]));
        out.extend(meta);
        out.extend(words(&[self.views.len() as u32]));
        for (view, lights) in &self.views {
            out.extend(floats(view));
            out.extend(words(&[lights.len() as u32]));
            lights.iter().for_each(|light| out.extend(floats(light)));
        }
        out.extend(words(&[self.width, self.height]));
        if self.signature.ends_with('R') {
            out.extend(rotations(self.rotations));
        }
        out
    }
}

pub fn words(numbers: &[u32]) -> Vec<u8> {
    numbers.iter().flat_map(|number| number.to_le_bytes()).collect()
}

pub fn floats(numbers: &[f32]) -> Vec<u8> {
    numbers.iter().flat_map(|number| number.to_le_bytes()).collect()
}

fn rotations(count: u32) -> Vec<u8> {
    [words(&[count]), vec![9; 36 * count as usize]].concat()
}

/// Numbers in a size of 2, 4 or 8 bytes.
pub fn scalars(size: u8, numbers: &[f64]) -> Vec<u8> {
    let bytes = |&number: &f64| match size {
        2 => f16::from_f64(number).to_le_bytes().to_vec(),
        4 => (number as f32).to_le_bytes().to_vec(),
        _ => number.to_le_bytes().to_vec(),
    };
    numbers.iter().flat_map(bytes).collect()
}

/// A number as it comes back from a size.
fn stored(size: u8, number: f64) -> f64 {
    match size {
        2 => f16::from_f64(number).to_f64(),
        4 => f64::from(number as f32),
        _ => number,
    }
}

/// Random factors of a matrix, and their bytes after the number of components.
pub struct Factored {
    pub count: usize,
    pub u: Vec<f64>,
    pub sxv: Vec<f64>,
    pub bytes: Vec<u8>,
}

impl Factored {
    pub fn random(size: u8, count: usize, rows: usize, columns: usize, seed: u64) -> Self {
        let mut random = Stream::new(seed, Purpose::Sample, [count as u64, rows as u64]);
        let mut numbers =
            |n: usize| -> Vec<f64> { (0..n).map(|_| stored(size, random.unit() - 0.4)).collect() };
        let (s, u, sxv) = (numbers(count), numbers(rows * count), numbers(columns * count));
        let sizes = words(&[count as u32, rows as u32, columns as u32]);
        let numbers = [scalars(size, &s), scalars(size, &u), scalars(size, &sxv)].concat();
        Self { count, u, sxv, bytes: [vec![size], sizes, numbers].concat() }
    }

    pub fn at(&self, row: usize, column: usize) -> f64 {
        (0..self.count).map(|k| self.u[row * self.count + k] * self.sxv[column * self.count + k]).sum()
    }
}

/// A file and the value of each pair, channel and texel.
pub struct BtfFile {
    pub head: Head,
    pub bytes: Vec<u8>,
    pub values: Vec<f64>,
}

impl BtfFile {
    fn new(head: Head, bytes: Vec<u8>, value: impl Fn(usize, usize, usize) -> f64) -> Self {
        let (channels, texels) = (head.channels.len(), head.texels());
        let count = head.pairs() * channels * texels;
        let at = |i: usize| value(i / texels / channels, i / texels % channels, i % texels);
        let values = (0..count).map(at).collect();
        Self { head, bytes, values }
    }

    pub fn value(&self, pair: usize, channel: usize, texel: usize) -> f64 {
        self.values[(pair * self.head.channels.len() + channel) * self.head.texels() + texel]
    }
}

/// A full matrix factorisation; `transposed` has channels of texels as rows. Of the extended header, `version` and
/// the flag for logarithms.
pub fn fmf(head: Head, size: u8, transposed: bool, extended: Option<(u8, u32)>) -> BtfFile {
    let (pairs, channels, texels, count) = (head.pairs(), head.channels.len(), head.texels(), 3);
    let [rows, columns] = if transposed { [texels * channels, pairs] } else { [pairs * channels, texels] };
    let matrix = Factored::random(size, count, rows, columns, 5);
    let mut bytes = head.bytes();
    let mut logarithms = false;
    if let Some((version, flag)) = extended {
        bytes.push(version);
        if version >= 1 {
            bytes.extend(words(&[flag]));
            logarithms = flag != 0;
        }
        if version >= 2 {
            bytes.extend(words(&[2, 3]));
            bytes.extend(scalars(2, &[0.5; 6]));
        }
    }
    bytes.extend(words(&[count as u32]));
    bytes.extend(&matrix.bytes);
    BtfFile::new(head, bytes, |pair, channel, texel| {
        let value = match transposed {
            false => matrix.at(pair * channels + channel, texel),
            true => matrix.at(channel + channels * texel, pair),
        };
        if logarithms { value.exp() - 1e-5 } else { value }
    })
}

/// A factorisation for each channel, with as many components as its number says; values before the colour model.
pub fn dfmf(head: Head, sizes: [u8; 3], transposed: bool, model: u32) -> BtfFile {
    let (pairs, texels) = (head.pairs(), head.texels());
    let [rows, columns] = if transposed { [texels, pairs] } else { [pairs, texels] };
    let matrices: Vec<Factored> = (0..head.channels.len())
        .map(|c| Factored::random(sizes[c % 3], 2 + c, rows, columns, 7 + c as u64))
        .collect();
    let mut bytes = [head.bytes(), words(&[4, model])].concat();
    bytes.extend(floats(&MEAN));
    bytes.extend(floats(MATRIX.as_flattened()));
    matrices.iter().for_each(|matrix| bytes.extend(&matrix.bytes));
    BtfFile::new(head, bytes, |pair, channel, texel| {
        let [row, column] = if transposed { [texel, pair] } else { [pair, texel] };
        matrices[channel].at(row, column)
    })
}

pub const MEAN: [f32; 3] = [0.5, 0.25, -0.125];
pub const MATRIX: [[f32; 3]; 3] = [[0.5, 0.25, 0.125], [1.0, -0.5, 0.0], [0.75, 0.0, 2.0]];

/// A factorisation for each view, of images or of functions of the light.
pub fn pvf(head: Head, size: u8, images: bool) -> BtfFile {
    let (channels, texels) = (head.channels.len(), head.texels());
    let mut bytes = [head.bytes(), words(&[2, head.views.len() as u32])].concat();
    let mut views = Vec::new();
    for (view, (_, lights)) in head.views.iter().enumerate() {
        let (count, lights) = (1 + view % 2, lights.len());
        let [length, weights] =
            if images { [channels * texels, lights] } else { [channels * lights, texels] };
        // U and S V serve as the components and the weights.
        let matrix = Factored::random(size, count, length, weights, 20 + view as u64);
        let mean: Vec<f64> = (0..length).map(|i| stored(size, 0.1 * i as f64)).collect();
        bytes.push(size);
        bytes.extend(words(&[count as u32, weights as u32, length as u32]));
        bytes.extend(scalars(size, &vec![1.0; count]));
        bytes.extend(scalars(size, &mean));
        bytes.extend(scalars(size, &matrix.u));
        bytes.extend(scalars(size, &matrix.sxv));
        views.push((matrix, mean));
    }
    let places = head.places();
    BtfFile::new(head, bytes, |pair, channel, texel| {
        let (view, light) = places[pair];
        let (matrix, mean) = &views[view];
        let [row, column] =
            if images { [channel + channels * texel, light] } else { [channel + channels * light, texel] };
        matrix.at(row, column) + mean[row]
    })
}

/// A file of images in chunks of `lines`, where the texels of `missing` are not stored.
pub fn bdi(head: Head, lines: usize, compression: u8, missing: &[usize]) -> BtfFile {
    let (pairs, channels, texels) = (head.pairs(), head.channels.len(), head.texels());
    let mut random = Stream::new(3, Purpose::Sample, [0]);
    let values: Vec<f64> =
        (0..texels * pairs * channels).map(|_| stored(2, 4.0 * random.unit() - 1.0)).collect();
    let mut bytes = [head.bytes(), words(&[lines as u32]), vec![compression]].concat();
    bytes.extend((0..texels).map(|texel| u8::from(!missing.contains(&texel))));
    bytes.extend(rotations(head.rotations));
    let kept: Vec<usize> = (0..texels).filter(|texel| !missing.contains(texel)).collect();
    for chunk in kept.chunks(lines * head.width as usize) {
        bytes.extend(words(&[(chunk.len() * pairs * channels * 2) as u32]));
        for texel in chunk {
            bytes.extend(scalars(2, &values[texel * pairs * channels..][..pairs * channels]));
        }
    }
    let missing = missing.to_vec();
    BtfFile::new(head, bytes, |pair, channel, texel| match missing.contains(&texel) {
        true => 0.0,
        false => values[texel * pairs * channels + pair * channels + channel],
    })
}

/// A small file of every kind.
pub fn small_btf_files() -> Vec<(String, BtfFile)> {
    let head = |signature, lights: &[usize]| Head::new(signature, lights, 3, 2);
    let mut files = vec![
        ("FMF".to_owned(), fmf(head("!FMF06FC", &[2, 3]), 4, false, None)),
        ("FMF with rotations, transposed".to_owned(), fmf(head("!FMF06FCR", &[3, 1]), 8, true, None)),
        ("sparse BDI".to_owned(), bdi(head("!BDIF06R2!", &[2, 2]), 1, 2, &[1, 4])),
        ("BDI".to_owned(), bdi(head("!BDIF06R2!", &[1, 2]), 2, 0, &[])),
    ];
    for version in 0..3 {
        let extended = Some((version, 1));
        files.push((format!("FMF {version}"), fmf(head("!FMF12FCER", &[2, 2]), 2, false, extended)));
    }
    for model in [0, 3, 11] {
        files
            .push((format!("DFMF {model}"), dfmf(head("!DFMF08FCR", &[2, 2]), [2, 4, 8], model == 3, model)));
    }
    for images in [false, true] {
        files.push((format!("PVF {images}"), pvf(head("!PVF06FC", &[2, 3]), 2, images)));
        files.push((format!("PVF with rotations {images}"), pvf(head("!PVF06FCR", &[2, 2]), 4, images)));
    }
    files
}
