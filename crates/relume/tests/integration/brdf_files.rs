//! Files of measured reflectances written from the descriptions of their formats and papers alone, from reflectances
//! given by formulas: nothing here is shared with the library's readers.

use std::f64::consts::{FRAC_PI_2, PI};

use relume::direction::Direction;

pub type Vector = [f64; 3];

/// A reflectance in red, green and blue for light and view.
pub type Reflectance<'a> = &'a dyn Fn(Vector, Vector) -> Vector;

/// A diffuse part and a lobe of Lafortune et al. (SIGGRAPH 1997) with coefficients for x, y and z: reciprocal, and
/// isotropic where those of x and y are equal.
pub fn lobe(coefficients: Vector, power: i32) -> impl Fn(Vector, Vector) -> Vector {
    move |light, view| {
        let inner: f64 = (0..3).map(|k| coefficients[k] * light[k] * view[k]).sum();
        let lobe = inner.max(0.0).powi(power);
        [0.3 / PI + 0.5 * lobe, 0.2 / PI + 0.4 * lobe, 0.1 / PI + 0.3 * lobe]
    }
}

pub fn unit(polar: f64, azimuth: f64) -> Vector {
    [polar.sin() * azimuth.cos(), polar.sin() * azimuth.sin(), polar.cos()]
}

pub fn direction(v: Vector) -> Direction {
    Direction::new(v[0], v[1], v[2]).unwrap()
}

fn dot(a: Vector, b: Vector) -> f64 {
    (0..3).map(|k| a[k] * b[k]).sum()
}

/// The mirror image of a direction about another.
pub fn mirrored(v: Vector, about: Vector) -> Vector {
    let twice = 2.0 * dot(v, about);
    std::array::from_fn(|k| twice * about[k] - v[k])
}

fn doubles(numbers: &[f64]) -> Vec<u8> {
    numbers.iter().flat_map(|number| number.to_le_bytes()).collect()
}

/// Light and view of the middle of a cell of a MERL table, whose half vector lies over the x axis.
pub fn merl_middle([half, difference, azimuth]: [usize; 3]) -> (Vector, Vector) {
    let half_polar = ((half as f64 + 0.5) / 90.0).powi(2) * FRAC_PI_2;
    let (polar, turn) = ((difference as f64 + 0.5).to_radians(), (azimuth as f64 + 0.5).to_radians());
    let [x, y, z] = unit(polar, turn);
    let (sin, cos) = half_polar.sin_cos();
    let light = [cos * x + sin * z, y, cos * z - sin * x];
    (light, mirrored(light, unit(half_polar, 0.0)))
}

/// A MERL `.binary` file with the reflectance of the middle of each cell, negative below the surface.
pub fn merl(reflectance: Reflectance) -> Vec<u8> {
    let scales = [1500.0, 1500.0 / 1.15, 1500.0 / 1.66];
    let mut planes: [Vec<f64>; 3] = Default::default();
    for cell in 0..90 * 90 * 180 {
        let (light, view) = merl_middle([cell / 180 / 90, cell / 180 % 90, cell % 180]);
        let above = light[2] > 0.0 && view[2] > 0.0;
        let values = if above { reflectance(light, view) } else { [-1.0; 3] };
        planes.iter_mut().enumerate().for_each(|(c, plane)| plane.push(values[c] * scales[c]));
    }
    let sizes: Vec<u8> = [90i32, 90, 180].iter().flat_map(|size| size.to_le_bytes()).collect();
    [sizes, doubles(&planes.concat())].concat()
}

/// A UTIA `.bin` file.
pub fn utia(reflectance: Reflectance) -> Vec<u8> {
    let node = |i: usize| unit((15.0 * (i / 48) as f64).to_radians(), (7.5 * (i % 48) as f64).to_radians());
    let mut planes: [Vec<f64>; 3] = Default::default();
    for (light, view) in (0..288).flat_map(|light| (0..288).map(move |view| (light, view))) {
        let values = reflectance(node(light), node(view));
        planes.iter_mut().enumerate().for_each(|(c, plane)| plane.push(values[c]));
    }
    doubles(&planes.concat())
}

/// A field of a tensor file.
pub struct Field {
    pub name: &'static str,
    pub kind: u8,
    pub shape: Vec<u64>,
    pub data: Vec<u8>,
}

impl Field {
    pub fn floats(name: &'static str, shape: &[usize], numbers: &[f64]) -> Self {
        assert_eq!(shape.iter().product::<usize>(), numbers.len(), "{name}");
        let data = numbers.iter().flat_map(|&number| (number as f32).to_le_bytes()).collect();
        Self { name, kind: 10, shape: shape.iter().map(|&side| side as u64).collect(), data }
    }

    pub fn bytes(name: &'static str, data: &[u8]) -> Self {
        Self { name, kind: 1, shape: vec![data.len() as u64], data: data.to_vec() }
    }
}

pub fn tensor_file(fields: &[Field]) -> Vec<u8> {
    let table: usize =
        fields.iter().map(|field| 2 + field.name.len() + 2 + 1 + 8 + 8 * field.shape.len()).sum();
    let mut out = b"tensor_file\0\x01\0".to_vec();
    out.extend((fields.len() as u32).to_le_bytes());
    let mut offset = out.len() + table;
    for field in fields {
        out.extend((field.name.len() as u16).to_le_bytes());
        out.extend(field.name.as_bytes());
        out.extend((field.shape.len() as u16).to_le_bytes());
        out.push(field.kind);
        out.extend((offset as u64).to_le_bytes());
        field.shape.iter().for_each(|side| out.extend(side.to_le_bytes()));
        offset += field.data.len();
    }
    fields.iter().for_each(|field| out.extend(&field.data));
    out
}

/// A density over the unit square, a + b u + c v + d u v, whose integrals have closed forms.
#[derive(Clone, Copy)]
pub struct Density(pub [f64; 4]);

impl Density {
    pub fn at(self, u: f64, v: f64) -> f64 {
        let [a, b, c, d] = self.0;
        a + b * u + c * v + d * u * v
    }

    /// The point of the square to which the uniform point (x, y) is warped: rows by the marginal, then in the row.
    pub fn warp(self, x: f64, y: f64) -> [f64; 2] {
        let [a, b, c, d] = self.0;
        let up_to = |v: f64| (a + b / 2.0) * v + (c + d / 2.0) * v * v / 2.0;
        let v = bisected(|v| up_to(v) / up_to(1.0) - y);
        let along = |u: f64| (a + c * v) * u + (b + d * v) * u * u / 2.0;
        [bisected(|u| along(u) / along(1.0) - x), v]
    }
}

/// The zero of an ascending function on [0, 1].
fn bisected(f: impl Fn(f64) -> f64) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..60 {
        let middle = (low + high) / 2.0;
        if f(middle) < 0.0 { low = middle } else { high = middle }
    }
    (low + high) / 2.0
}

/// How an RGL file is written.
pub struct RglSetup {
    /// The tabulated incident azimuths.
    pub azimuths: Vec<f64>,
    /// The tabulated incident polar angles.
    pub polars: Vec<f64>,
    /// Nodes along each side of the tables.
    pub nodes: usize,
    /// Wavelengths in nm, with the reflectance of each as a share of that of green; none for RGB.
    pub spectrum: Vec<(f64, f64)>,
    /// Whether the distribution and the areas are divided out.
    pub jacobian: bool,
}

impl RglSetup {
    pub fn is_isotropic(&self) -> bool {
        self.azimuths.len() <= 2
    }

    /// The densities of the warp of an incident direction: different for each.
    fn density(&self, azimuth: usize, polar: usize) -> Density {
        let (p, a) = (polar as f64 / self.polars.len() as f64, azimuth as f64 / self.azimuths.len() as f64);
        Density([0.6 + 0.3 * p, 0.8 - 0.5 * p, 0.2 * a, 0.3 * p])
    }

    /// The distribution of normals: any will do, as it is divided out.
    const DISTRIBUTION: Density = Density([0.7, 0.4, 0.2, -0.1]);

    /// The projected areas: any that do not depend on the azimuth of an isotropic material.
    fn areas(&self) -> Density {
        Density(if self.is_isotropic() { [0.5, -0.2, 0.0, 0.0] } else { [0.5, -0.2, 0.1, 0.1] })
    }

    /// The incident and the outgoing direction of a node of the tables.
    pub fn directions(&self, azimuth: usize, polar: usize, x: usize, y: usize) -> (Vector, Vector) {
        let at = |i: usize| i as f64 / (self.nodes - 1) as f64;
        let [u, v] = self.density(azimuth, polar).warp(at(x), at(y));
        let incident_azimuth = self.azimuths[azimuth];
        let incident = unit(self.polars[polar], incident_azimuth);
        let turn = if self.is_isotropic() { incident_azimuth } else { 0.0 };
        let half = unit(u * u * FRAC_PI_2, (2.0 * v - 1.0) * PI + turn);
        (incident, mirrored(incident, half))
    }

    /// The value of the tables at a node: the reflectance times the cosine of the outgoing direction, over the
    /// distribution and times four areas.
    fn value(&self, reflectance: Reflectance, [azimuth, polar, y, x]: [usize; 4]) -> Vector {
        let (incident, outgoing) = self.directions(azimuth, polar, x, y);
        if outgoing[2] <= 0.0 {
            return [0.0; 3];
        }
        let at = |i: usize| i as f64 / (self.nodes - 1) as f64;
        let [u, v] = self.density(azimuth, polar).warp(at(x), at(y));
        let incident_u = (self.polars[polar] / FRAC_PI_2).sqrt();
        let incident_v = (self.azimuths[azimuth] + PI) / (2.0 * PI);
        let scale = match self.jacobian {
            true => 4.0 * self.areas().at(incident_u, incident_v) / Self::DISTRIBUTION.at(u, v),
            false => 1.0,
        };
        // Light and view: the view is the incident direction of the tables.
        reflectance(outgoing, incident).map(|value| value * outgoing[2] * scale)
    }

    pub fn fields(&self, reflectance: Reflectance) -> Vec<Field> {
        let (a, p, n) = (self.azimuths.len(), self.polars.len(), self.nodes);
        let square = |density: Density, n: usize| -> Vec<f64> {
            let at = |i: usize| i as f64 / (n - 1) as f64;
            (0..n * n).map(|i| density.at(at(i % n), at(i / n))).collect()
        };
        let slices: Vec<(usize, usize)> = (0..a * p).map(|i| (i / p, i % p)).collect();
        let visible: Vec<f64> = slices
            .iter()
            .flat_map(|&(a, p)| square(self.density(a, p), 5).into_iter().map(|v| 3.5 * v))
            .collect();
        let channels = if self.spectrum.is_empty() { 3 } else { self.spectrum.len() };
        let mut colors = vec![0.0; a * p * channels * n * n];
        for (slice, &(azimuth, polar)) in slices.iter().enumerate() {
            for i in 0..n * n {
                let rgb = self.value(reflectance, [azimuth, polar, i / n, i % n]);
                for channel in 0..channels {
                    let value =
                        self.spectrum.get(channel).map_or(rgb[channel.min(2)], |(_, share)| rgb[1] * share);
                    colors[(slice * channels + channel) * n * n + i] = value;
                }
            }
        }
        let name = if self.spectrum.is_empty() { "rgb" } else { "spectra" };
        let mut fields = vec![
            Field::bytes("description", b"made from a formula"),
            Field::floats("phi_i", &[a], &self.azimuths),
            Field::floats("theta_i", &[p], &self.polars),
            Field::floats("ndf", &[7, 7], &square(Self::DISTRIBUTION, 7)),
            Field::floats("sigma", &[6, 6], &square(self.areas(), 6)),
            Field::floats("vndf", &[a, p, 5, 5], &visible),
            Field::floats("luminance", &[a, p, n, n], &vec![1.0; a * p * n * n]),
            Field::floats(name, &[a, p, channels, n, n], &colors),
            Field::bytes("jacobian", &[u8::from(self.jacobian)]),
        ];
        if !self.spectrum.is_empty() {
            let wavelengths: Vec<f64> = self.spectrum.iter().map(|(nm, _)| *nm).collect();
            fields.push(Field::floats("wavelengths", &[wavelengths.len()], &wavelengths));
        }
        fields
    }

    pub fn file(&self, reflectance: Reflectance) -> Vec<u8> {
        tensor_file(&self.fields(reflectance))
    }
}

/// A small RGL file, in RGB and spectral.
pub fn small_rgl_files() -> Vec<(String, Vec<u8>)> {
    [vec![], vec![(450.0, 0.5), (600.0, 1.0)]]
        .into_iter()
        .map(|spectrum| {
            let setup =
                RglSetup { azimuths: vec![0.0], polars: vec![0.1, 1.2], nodes: 2, spectrum, jacobian: true };
            (format!("RGL of {} wavelengths", setup.spectrum.len()), setup.file(&lobe([-0.5, -0.5, 0.8], 1)))
        })
        .collect()
}
