//! The data with which the shader of the page draws endless noise of functions.
//!
//! Under a given light the colour of a texel is linear in its index values, and those are the mean plus the
//! sum of the principal axes, each times the value of its plane. So the shader needs the normal values of the
//! planes, one byte each, the tables that restore the values, and the functions of the mean and of each axis,
//! which the page turns into one colour per light.

use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use relume::field::{Domain, IndexSpace, Metric, PlaneLayout};
use relume::format::{Depth, PictureFormat, encode_picture, read_field};
use relume::synthesis::noise::gaussian::REACH;
use relume::synthesis::noise::{Noise, NoiseOptions};
use relume::{Error, Job, Picture, Planes, ReflectanceField, Result, Size, Space};
use serde_json::{Value, json};

use super::page::png_uri;

/// Noise and the functions of its axes.
pub struct NoiseData {
    noise: Noise,
    /// The mean function, and that of each axis, as coefficients of red, green and blue.
    functions: Vec<Vec<f32>>,
}

impl NoiseData {
    /// Models the functions in a file.
    pub fn read(path: &Path, job: &Job) -> Result<Self> {
        Self::new(&read_field(path, job)?.field, job).map_err(|e| e.at(path))
    }

    fn new(field: &ReflectanceField, job: &Job) -> Result<Self> {
        if *field.layout() != PlaneLayout::RGB {
            return Err(Error::invalid("the page needs functions of red, green and blue"));
        }
        let space = IndexSpace::new(field, Metric::Function, Domain::Hemisphere)?;
        let noise = Noise::new(&space.index_planes(field), &NoiseOptions::default(), job)?;
        let functions = functions(&noise, &space, field)?;
        Ok(Self { noise, functions })
    }

    /// The size of the exemplar.
    pub fn size(&self) -> Size {
        self.noise.size()
    }

    /// The number of planes.
    pub fn planes(&self) -> usize {
        self.noise.marginals().len()
    }

    /// In the form the script of the page expects.
    pub fn to_json(&self) -> Result<Value> {
        let picture = Picture { planes: self.normals(), space: Space::Srgb };
        let tables = self.noise.marginals().iter().flat_map(|marginal| marginal.table());
        let tables: Vec<u8> = tables.flat_map(|value| value.to_le_bytes()).collect();
        Ok(json!({
            "normals": png_uri(&encode_picture(&picture, PictureFormat::Png(Depth::Eight))?),
            "tables": STANDARD.encode(tables),
            "entries": self.noise.marginals()[0].table().len(),
            "planes": self.planes(),
            "reach": REACH,
            "key": [self.noise.key() as u32, (self.noise.key() >> 32) as u32],
            "side": self.noise.side(),
            "size": [self.size().width, self.size().height],
            "mean": self.functions[0],
            "axes": self.functions[1..],
        }))
    }

    /// The normal values from 0 to 1, three planes side by side as red, green and blue, the next three below.
    fn normals(&self) -> Planes {
        let (planes, size) = (self.noise.normal_planes(), self.size());
        let layers = self.planes().div_ceil(3);
        let mut stacked = Planes::zeros(Size::new(size.width, layers * size.height), 3);
        for (k, plane) in planes.iter().enumerate() {
            let first = k / 3 * size.texels();
            let part = &mut stacked.plane_mut(k % 3)[first..][..size.texels()];
            part.iter_mut().zip(plane).for_each(|(out, normal)| *out = normal / REACH as f32 * 0.5 + 0.5);
        }
        stacked
    }
}

/// The function of the mean, and the contribution of each axis.
fn functions(noise: &Noise, space: &IndexSpace, like: &ReflectanceField) -> Result<Vec<Vec<f32>>> {
    let (means, axes) = noise.axes();
    let mut index = Planes::zeros(Size::new(axes.rows() + 1, 1), means.len());
    for (j, mean) in means.iter().enumerate() {
        let plane = index.plane_mut(j);
        plane.fill(*mean);
        (0..axes.rows()).for_each(|k| plane[k + 1] += axes[(k, j)] as f32);
    }
    let field = space.field(like, &index)?;
    let coefficients = field.coefficients();
    let of = |texel: usize| (0..coefficients.count()).map(move |c| coefficients.at(c, texel, 0));
    let added = (1..=axes.rows()).map(|k| of(k).zip(of(0)).map(|(axis, mean)| axis - mean).collect());
    Ok(std::iter::once(of(0).collect()).chain(added).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use relume::Direction;
    use relume::field::Basis;
    use relume::format::decode_raster;
    use relume::numeric::hash;
    use relume::numeric::random::{Purpose, Stream};

    /// Functions that vary from texel to texel about a common one.
    fn field() -> ReflectanceField {
        let size = Size::new(64, 60);
        let mut stream = Stream::new(5, Purpose::Sample, [0]);
        let rough: Vec<f32> = (0..size.texels()).map(|_| stream.unit().powi(2) as f32).collect();
        let data = (0..18 * size.texels()).map(|i| {
            let own = 0.08 * stream.unit() as f32;
            if i / size.texels() % 6 == 5 { 0.2 + 0.4 * rough[i % size.texels()] + own } else { own }
        });
        let planes = Planes::from_vec(size, 18, data.collect()).unwrap();
        ReflectanceField::new(Basis::Ptm, PlaneLayout::RGB, Space::Srgb, planes).unwrap()
    }

    /// The shader of the page in Rust, on the data of the page, in single precision as well.
    struct ShaderTwin {
        normals: relume::Raster,
        tables: Vec<f32>,
        data: Value,
    }

    impl ShaderTwin {
        fn new(data: Value) -> Self {
            let png = data["normals"].as_str().unwrap().strip_prefix("data:image/png;base64,").unwrap();
            let normals = decode_raster(&STANDARD.decode(png).unwrap(), &Job::default()).unwrap();
            let bytes = STANDARD.decode(data["tables"].as_str().unwrap()).unwrap();
            let tables = bytes.chunks_exact(4).map(|b| f32::from_le_bytes(b.try_into().unwrap())).collect();
            Self { normals, tables, data }
        }

        fn number(&self, key: &str) -> f64 {
            self.data[key].as_f64().unwrap()
        }

        fn value(functions: &Value, light: Direction, channel: usize) -> f32 {
            let weights = Basis::Ptm.weights(light);
            (0..6).map(|k| weights[k] * functions[6 * channel + k].as_f64().unwrap()).sum::<f64>() as f32
        }

        fn source(&self, base: [i64; 2], fraction: [f32; 2], vertex: [i32; 2], p: [i32; 2]) -> [usize; 2] {
            let side = self.number("side") as f32;
            let [i, j] = vertex.map(|n| n as f32);
            let place = [side * (i + 0.5 * j), side * 0.866_025_4 * j];
            let key = [0, 1].map(|half| self.data["key"][half].as_u64().unwrap() as u32);
            let [x, y] = [0, 1].map(|axis| (base[axis] + i64::from(vertex[axis])) as u32);
            let hash = hash::hash4([x, y, key[0], key[1]]);
            let margin = side as i32 + 1;
            [0, 1].map(|axis| {
                let room = (self.data["size"][axis].as_u64().unwrap() as i32 - 2 * margin) as u32;
                let among = ((hash[axis] >> 16) * room + (((hash[axis] & 65535) * room) >> 16)) >> 16;
                let middle = (place[axis] + fraction[axis] + 0.5).floor() as i32;
                (margin + among as i32 + p[axis] - middle) as usize
            })
        }

        /// The colour of the texel at (x, y) in a view whose upper left one is `corner`.
        fn color(&self, corner: [i64; 2], [x, y]: [i32; 2], light: Direction) -> [f32; 3] {
            let side = self.number("side");
            let height = side * 0.75f64.sqrt();
            let j = (corner[1] as f64 / height).floor();
            let i = (corner[0] as f64 / side - 0.5 * j).floor();
            let vertex = [side * (i + 0.5 * j), height * j];
            let fraction = vertex.map(|v| (v - v.floor()) as f32);
            let p = [
                x + (corner[0] - vertex[0].floor() as i64) as i32,
                y + (corner[1] - vertex[1].floor() as i64) as i32,
            ];
            let down = (p[1] as f32 - fraction[1]) / height as f32;
            let across = (p[0] as f32 - fraction[0]) / side as f32 - 0.5 * down;
            let (c, r) = (across.floor() as i32, down.floor() as i32);
            let (s, t) = (across - across.floor(), down - down.floor());
            let corners = if s + t < 1.0 {
                [([c, r], 1.0 - s - t), ([c + 1, r], s), ([c, r + 1], t)]
            } else {
                [([c + 1, r + 1], s + t - 1.0), ([c, r + 1], 1.0 - s), ([c + 1, r], 1.0 - t)]
            };
            let length = corners.iter().map(|(_, w)| w * w).sum::<f32>().sqrt();
            let sources =
                corners.map(|(v, w)| (self.source([i as i64, j as i64], fraction, v, p), w / length));
            let mut sum = [0, 1, 2].map(|channel| Self::value(&self.data["mean"], light, channel));
            for k in 0..self.data["planes"].as_u64().unwrap() as usize {
                let normal: f32 =
                    sources.iter().map(|(at, w)| w * (2.0 * self.stored(k, *at) - 1.0) * 4.0).sum();
                let value = self.put(k, normal);
                for (channel, sum) in sum.iter_mut().enumerate() {
                    *sum += Self::value(&self.data["axes"][k], light, channel) * value;
                }
            }
            sum
        }

        fn stored(&self, k: usize, [x, y]: [usize; 2]) -> f32 {
            let row = k / 3 * self.data["size"][1].as_u64().unwrap() as usize + y;
            self.normals.samples().value(self.normals.size().index(x, row) * 3 + k % 3)
        }

        fn put(&self, k: usize, normal: f32) -> f32 {
            let entries = self.data["entries"].as_u64().unwrap() as usize;
            let place = ((normal / 4.0 * 0.5 + 0.5) * (entries - 1) as f32).clamp(0.0, (entries - 1) as f32);
            let (below, share) = (place as usize, place.fract());
            let at = |i: usize| self.tables[k * entries + i.min(entries - 1)];
            at(below) + share * (at(below + 1) - at(below))
        }
    }

    #[test]
    fn the_shader_draws_the_librarys_plane() {
        let (field, job) = (field(), Job::default());
        let data = NoiseData::new(&field, &job).unwrap();
        let space = IndexSpace::new(&field, Metric::Function, Domain::Hemisphere).unwrap();
        let shader = ShaderTwin::new(data.to_json().unwrap());
        let light = Direction::new(-0.5, 0.4, 0.7).unwrap();
        for corner in [[0, 0], [-17, 1234], [-987_654_321, 123_456_789]] {
            let size = Size::new(90, 50);
            let index = data.noise.window(corner[0], corner[1], size, &job).unwrap();
            let made = space.field(&field, &index).unwrap();
            let (mut sum, mut most) = (0.0, 0.0f32);
            for (x, y) in (0..50).flat_map(|y| (0..90).map(move |x| (x, y))) {
                let (expected, found) =
                    (made.value(x, y, light), shader.color(corner, [x as i32, y as i32], light));
                for (a, b) in expected.iter().zip(found) {
                    sum += (a - b).abs();
                    most = most.max((a - b).abs());
                }
            }
            // Normal values are stored in steps of 8 / 255.
            let mean = sum / (3 * size.texels()) as f32;
            assert!(mean < 0.5 / 255.0 && most < 4.0 / 255.0, "{corner:?}: mean {mean}, most {most}");
        }
    }

    #[test]
    fn only_functions_of_three_channels_are_taken() {
        let lrgb = field().coefficients().crop(0, 0, Size::new(40, 40)).unwrap();
        let planes = Planes::from_vec(lrgb.size(), 9, lrgb.as_slice()[..9 * 1600].to_vec()).unwrap();
        let field = ReflectanceField::new(Basis::Ptm, PlaneLayout::LRGB, Space::Srgb, planes).unwrap();
        assert!(NoiseData::new(&field, &Job::default()).is_err());
    }
}
