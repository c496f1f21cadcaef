//! Endless noise of an exemplar as web pages load it.

use crate::error::{Error, Result};
use crate::field::{Domain, IndexSpace, Metric, PlaneLayout, ReflectanceField};
use crate::format::share::{NoiseParts, ShareFiles};
use crate::job::Job;
use crate::planes::Planes;
use crate::size::Size;
use crate::synthesis::noise::gaussian::REACH;
use crate::synthesis::noise::{Noise, NoiseOptions};
use crate::workflow::share::ShareOptions;

/// Noise of functions, and the functions of its axes.
///
/// Under a given light the colour of a texel is linear in its index values, and those are the mean plus the
/// sum of the principal axes, each times the value of its plane. So a shader needs the normal values of the
/// planes, the tables that restore the values, and the coefficients of the mean and of each axis.
#[derive(Debug)]
pub struct NoiseFunctions {
    noise: Noise,
    like: ReflectanceField,
    functions: Vec<Vec<f32>>,
}

impl NoiseFunctions {
    /// Models a field of one function, or of functions of red, green and blue; products of luminance and colour are
    /// multiplied out.
    ///
    /// # Errors
    /// Other fields, exemplars unsuitable for noise, and limits exceeded.
    pub fn new(field: &ReflectanceField, options: &NoiseOptions, job: &Job) -> Result<Self> {
        if field.layout().is_product() {
            return Self::new(&field.of_channels(&["R", "G", "B"], job)?, options, job);
        }
        if ![PlaneLayout::RGB, PlaneLayout::LUMINANCE].contains(field.layout()) {
            return Err(Error::usage(format!(
                "noise is shown of functions of one channel or of red, green and blue, and this is a {} field",
                field.layout().name()
            )));
        }
        let space = IndexSpace::new(field, Metric::Function, Domain::Hemisphere)?;
        let noise =
            Noise::new(&space.index_planes_within(field, job, "the index of the exemplar")?, options, job)?;
        let functions = functions(&noise, &space, field)?;
        let texel = Planes::zeros(Size::new(1, 1), field.coefficients().count());
        let like =
            ReflectanceField::new(field.basis().clone(), field.layout().clone(), field.space(), texel)?;
        Ok(Self { noise, like, functions })
    }

    /// The noise.
    pub fn noise(&self) -> &Noise {
        &self.noise
    }

    /// The coefficients of the mean, channel after channel, and then the contribution of each axis.
    pub fn functions(&self) -> &[Vec<f32>] {
        &self.functions
    }

    /// The number of planes.
    pub fn planes(&self) -> usize {
        self.noise.marginals().len()
    }

    /// The files of the noise.
    ///
    /// # Errors
    /// Memory, and a cancelled job.
    pub fn share(&self, options: &ShareOptions, job: &Job) -> Result<ShareFiles> {
        let parts = NoiseParts {
            normals: &self.noise.normal_planes(),
            tables: self.noise.marginals().iter().map(|marginal| marginal.table()).collect(),
            reach: REACH as f32,
            side: self.noise.side(),
            key: self.noise.key(),
            functions: &self.functions,
        };
        ShareFiles::of_noise(&parts, &self.like, &options.title, options.depth, options.mm_per_texel, job)
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
    use crate::direction::Direction;
    use crate::field::Basis;
    use crate::format::decode_raster;
    use crate::format::share::planes::PlaneDepth;
    use crate::format::share::{ShareHeader, ShareNoise};
    use crate::numeric::hash;
    use crate::numeric::random::{Purpose, Stream};
    use crate::raster::Raster;
    use crate::space::Space;
    use std::io::Read;

    /// Functions that vary from texel to texel about a common one.
    fn field(layout: PlaneLayout) -> ReflectanceField {
        let size = Size::new(64, 60);
        let mut stream = Stream::new(5, Purpose::Sample, [0]);
        let rough: Vec<f32> = (0..size.texels()).map(|_| stream.unit().powi(2) as f32).collect();
        let count = layout.planes(6);
        let data = (0..count * size.texels()).map(|i| {
            let own = 0.08 * stream.unit() as f32;
            if i / size.texels() % 6 == 5 { 0.2 + 0.4 * rough[i % size.texels()] + own } else { own }
        });
        let planes = Planes::from_vec(size, count, data.collect()).unwrap();
        ReflectanceField::new(Basis::Ptm, layout, Space::Srgb, planes).unwrap()
    }

    /// The shader of the viewer (web/packages/relume-three/src/noise.ts) in Rust, on the files that it loads, in single precision as
    /// well.
    struct NoiseTwin {
        header: ShareHeader,
        normals: Vec<Raster>,
        tables: Vec<f32>,
        functions: Vec<f32>,
    }

    impl NoiseTwin {
        fn new(shared: &ShareFiles) -> Self {
            let bytes = |name: &str| &shared.files.iter().find(|(file, _)| file == name).unwrap().1[..];
            let floats = |name: &str| -> Vec<f32> {
                let mut raw = Vec::new();
                flate2::read::GzDecoder::new(bytes(name)).read_to_end(&mut raw).unwrap();
                raw.chunks_exact(4).map(|b| f32::from_le_bytes(b.try_into().unwrap())).collect()
            };
            let header = shared.header.clone();
            let noise = header.noise.clone().unwrap();
            let pictures =
                header.planes.iter().map(|group| decode_raster(bytes(&group.file), &Job::default()));
            Self {
                normals: pictures.map(Result::unwrap).collect(),
                tables: floats(&noise.tables),
                functions: floats(&noise.functions),
                header,
            }
        }

        fn noise(&self) -> &ShareNoise {
            self.header.noise.as_ref().unwrap()
        }

        fn source(&self, base: [i64; 2], fraction: [f32; 2], vertex: [i32; 2], p: [i32; 2]) -> [usize; 2] {
            let side = self.noise().side as f32;
            let [i, j] = vertex.map(|n| n as f32);
            let place = [side * (i + 0.5 * j), side * 0.866_025_4 * j];
            let [x, y] = [0, 1].map(|axis| (base[axis] + i64::from(vertex[axis])) as u32);
            let hash = hash::hash4([x, y, self.noise().key[0], self.noise().key[1]]);
            let margin = side as i32 + 1;
            [0, 1].map(|axis| {
                let room = (self.header.size[axis] as i32 - 2 * margin) as u32;
                let among = ((hash[axis] >> 16) * room + (((hash[axis] & 65535) * room) >> 16)) >> 16;
                let middle = (place[axis] + fraction[axis] + 0.5).floor() as i32;
                (margin + among as i32 + p[axis] - middle) as usize
            })
        }

        /// The coefficients of the texel at (x, y) of a square whose upper left one is `corner`.
        fn coefficients(&self, corner: [i64; 2], [x, y]: [i32; 2]) -> Vec<f32> {
            let side = self.noise().side;
            let height = side * 0.75f64.sqrt();
            let j = (corner[1] as f64 / height).floor();
            let i = (corner[0] as f64 / side - 0.5 * j).floor();
            let vertex = [side * (i + 0.5 * j), height * j];
            let fraction = vertex.map(|v| (v - v.floor()) as f32);
            let p = [0, 1].map(|axis| [x, y][axis] + (corner[axis] - vertex[axis].floor() as i64) as i32);
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
            let each = self.functions.len() / (self.noise().planes + 1);
            let mut sum = self.functions[..each].to_vec();
            for k in 0..self.noise().planes {
                let normal: f32 = sources.iter().map(|(at, w)| w * self.normal(k, *at)).sum();
                let (value, axis) = (self.restored(k, normal), &self.functions[(k + 1) * each..][..each]);
                sum.iter_mut().zip(axis).for_each(|(sum, axis)| *sum += axis * value);
            }
            sum
        }

        fn normal(&self, k: usize, [x, y]: [usize; 2]) -> f32 {
            let at =
                self.header.planes.iter().position(|g| (g.first..g.first + g.count).contains(&k)).unwrap();
            let (group, raster) = (&self.header.planes[at], &self.normals[at]);
            let place = raster.size().index(x, y) * group.count + k - group.first;
            let code = raster.samples().value(place) * 255.0;
            group.scale[k - group.first] * code + group.offset[k - group.first]
        }

        fn restored(&self, k: usize, normal: f32) -> f32 {
            let (entries, reach) = (self.noise().entries, self.noise().reach);
            let place =
                ((normal / reach * 0.5 + 0.5) * (entries - 1) as f32).clamp(0.0, (entries - 1) as f32);
            let (below, share) = (place as usize, place.fract());
            let at = |i: usize| self.tables[k * entries + i.min(entries - 1)];
            at(below) + share * (at(below + 1) - at(below))
        }
    }

    #[test]
    fn the_shader_draws_the_librarys_plane() {
        let job = Job::default();
        let options = ShareOptions {
            title: String::new(),
            depth: PlaneDepth::Kept,
            mm_per_texel: None,
            environment: None,
        };
        let light = Direction::new(-0.5, 0.4, 0.7).unwrap();
        for layout in [PlaneLayout::RGB, PlaneLayout::LUMINANCE] {
            let field = field(layout);
            let data = NoiseFunctions::new(&field, &NoiseOptions::default(), &job).unwrap();
            let space = IndexSpace::new(&field, Metric::Function, Domain::Hemisphere).unwrap();
            let twin = NoiseTwin::new(&data.share(&options, &job).unwrap());
            for corner in [[0, 0], [-17, 1234], [-987_654_321, 123_456_789]] {
                let size = Size::new(60, 40);
                let index = data.noise().window(corner[0], corner[1], size, &job).unwrap();
                let made = space.field(&field, &index).unwrap();
                let weights = Basis::Ptm.weights(light);
                let (mut sum, mut most) = (0.0, 0.0f32);
                for (x, y) in (0..40).flat_map(|y| (0..60).map(move |x| (x, y))) {
                    let found = twin.coefficients(corner, [x as i32, y as i32]);
                    for (expected, found) in made.values(x, y, light).iter().zip(found.chunks_exact(6)) {
                        let value = found.iter().zip(&weights).map(|(c, w)| f64::from(*c) * w).sum::<f64>();
                        sum += (expected - value as f32).abs();
                        most = most.max((expected - value as f32).abs());
                    }
                }
                // Normal values are stored in steps of 8 / 255.
                let mean = sum / (field.layout().channels() * size.texels()) as f32;
                assert!(mean < 0.5 / 255.0 && most < 4.0 / 255.0, "{corner:?}: mean {mean}, most {most}");
            }
        }
    }

    #[test]
    fn products_are_multiplied_out() {
        let data = NoiseFunctions::new(&field(PlaneLayout::LRGB), &NoiseOptions::default(), &Job::default())
            .unwrap();
        assert_eq!((data.planes(), data.functions()[0].len()), (18, 18));
    }
}
