//! The data with which the shader of the page draws endless noise of functions, as its script expects it.

use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use relume::format::read_field;
use relume::synthesis::noise::gaussian::REACH;
use relume::workflow::shader::NoiseFunctions;
use relume::{Job, Result};
use serde_json::{Value, json};

use crate::html::picture_uri;

/// Models the functions in a file.
pub fn read(path: &Path, job: &Job) -> Result<NoiseFunctions> {
    NoiseFunctions::new(&read_field(path, job)?.field, job).map_err(|e| e.at(path))
}

/// In the form the script of the page expects.
pub fn to_json(functions: &NoiseFunctions) -> Result<Value> {
    let noise = functions.noise();
    let tables = noise.marginals().iter().flat_map(|marginal| marginal.table());
    let tables: Vec<u8> = tables.flat_map(|value| value.to_le_bytes()).collect();
    let (mean, axes) = functions.functions().split_first().expect("the mean is always there");
    Ok(json!({
        "normals": picture_uri(&functions.normals())?,
        "tables": STANDARD.encode(tables),
        "entries": noise.marginals()[0].table().len(),
        "planes": functions.planes(),
        "reach": REACH,
        "key": [noise.key() as u32, (noise.key() >> 32) as u32],
        "side": noise.side(),
        "size": [noise.size().width, noise.size().height],
        "mean": mean,
        "axes": axes,
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use relume::field::{Basis, Domain, IndexSpace, Metric, PlaneLayout};
    use relume::format::decode_raster;
    use relume::numeric::hash;
    use relume::numeric::random::{Purpose, Stream};
    use relume::{Direction, Planes, ReflectanceField, Size, Space};

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
        let data = NoiseFunctions::new(&field, &job).unwrap();
        let space = IndexSpace::new(&field, Metric::Function, Domain::Hemisphere).unwrap();
        let shader = ShaderTwin::new(to_json(&data).unwrap());
        let light = Direction::new(-0.5, 0.4, 0.7).unwrap();
        for corner in [[0, 0], [-17, 1234], [-987_654_321, 123_456_789]] {
            let size = Size::new(90, 50);
            let index = data.noise().window(corner[0], corner[1], size, &job).unwrap();
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
        assert!(NoiseFunctions::new(&field, &Job::default()).is_err());
    }
}
