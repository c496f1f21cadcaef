//! A field to a folder that OpenLIME shows right.
//!
//! OpenLIME takes relit values for sRGB-encoded whatever the folder says, shows six polynomials and nine harmonics at
//! most, and needs a coarsest level of one whole tile. Every channel of every coefficient has a scale and a bias of its
//! own, for the least expected error.

use serde_json::json;

use super::tiles::{TILE_SIDE, TileGrid, levels};
use super::{INFO_FILE, functions};
use crate::error::{Error, Result};
use crate::field::refit::refit;
use crate::field::{Basis, PlaneLayout, ReflectanceField};
use crate::format::codes::code8;
use crate::format::folder::StoreFile;
use crate::format::ptm::{PtmEncoding, check_finite, nearest_byte};
use crate::format::{jpeg, multires, quantise};
use crate::job::Job;
use crate::names::named;
use crate::numeric::Matrix;
use crate::numeric::matrix::Qr;
use crate::parallel;
use crate::size::Size;
use crate::space::Space;

/// How the planes of a folder are stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum WebLayout {
    /// One picture for each three coefficients.
    #[default]
    Plain,
    /// Tiles in files of their own.
    Deepzoom,
    /// Tiles in one file for each three coefficients.
    Tarzoom,
    /// Tiles in one file for all of them.
    Itarzoom,
    /// The folder of the older web RTI viewer instead: `info.xml`, and the tiles of a quadtree.
    Multires,
}

named!(WebLayout { Plain => "plain", Deepzoom => "deepzoom", Tarzoom => "tarzoom", Itarzoom => "itarzoom", Multires => "multires" });

impl WebLayout {
    /// Whether the viewers of such folders show functions of this name.
    pub fn shows(self, basis: &str) -> bool {
        ["ptm", "hsh4", "hsh9"].contains(&basis) || (basis == "sh9" && self != Self::Multires)
    }
}

/// The options of a folder.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct WebOptions {
    /// How planes are stored.
    pub layout: WebLayout,
    /// The quality of JPEG files, 1 to 100.
    pub quality: u8,
}

impl Default for WebOptions {
    fn default() -> Self {
        Self { layout: WebLayout::Plain, quality: 95 }
    }
}

/// The bytes of three coefficients, interleaved.
type Picture3 = Vec<u8>;

/// Writes a field of polynomials or harmonics as a web folder: `store` gets the files, by their paths within it.
///
/// # Errors
/// Functions that viewers do not show, named channels, linear values and values that are not finite, all in words;
/// those of `store`.
pub fn encode_web(
    field: &ReflectanceField,
    options: &WebOptions,
    job: &Job,
    store: &mut StoreFile<'_>,
) -> Result<()> {
    if options.layout == WebLayout::Multires {
        return multires::encode(field, options.quality, job, store);
    }
    let (kind, matrix) = check(field)?;
    let coded = Coded::of(field, kind, &matrix, job)?;
    store(INFO_FILE, coded.info(options.quality).as_bytes())?;
    match options.layout {
        WebLayout::Plain => {
            for (k, picture) in coded.pictures.iter().enumerate() {
                job.proceed()?;
                store(&format!("plane_{k}.jpg"), &jpeg::encode(picture, coded.size, 3, options.quality)?)?;
            }
            Ok(())
        }
        WebLayout::Deepzoom => deepzoom(&coded, options.quality, job, store),
        WebLayout::Tarzoom => {
            for (k, picture) in coded.pictures.iter().enumerate() {
                archive(&format!("plane_{k}"), &[picture], coded.size, options.quality, job, store)?;
            }
            Ok(())
        }
        WebLayout::Itarzoom | WebLayout::Multires => {
            let pictures: Vec<&Picture3> = coded.pictures.iter().collect();
            archive("planes", &pictures, coded.size, options.quality, job, store)
        }
    }
}

/// The type of the folder, and its functions' coefficients from those of the field.
fn check(field: &ReflectanceField) -> Result<(&'static str, Matrix)> {
    let basis = field.basis();
    let n = basis.len();
    if field.layout().is_named() || field.layout().is_shared() {
        return Err(Error::usage(
            "a web folder holds red, green and blue, each with functions of its own: relume convert makes them",
        ));
    }
    if field.space() != Space::Srgb {
        return Err(Error::usage(
            "viewers of web folders show sRGB-encoded values and this texture is linear: give --space srgb, or fit \
             encoded values",
        ));
    }
    check_finite(field, "web folder's")?;
    let identity = Matrix::from_fn(n, n, |r, c| f64::from(u8::from(r == c)));
    match basis.name() {
        "ptm" => Ok(("ptm", inverse_order(basis, n, functions::monomials)?)),
        "hsh4" | "hsh9" => Ok(("hsh", identity)),
        "sh9" => Ok(("sh", inverse_order(basis, n, functions::spherical)?)),
        other => Err(Error::usage(format!(
            "viewers of web folders show ptm, hsh9 and sh9, not {other}: relume convert --basis hsh9 makes the nearest"
        ))),
    }
}

/// The matrix from coefficients of a basis to those of functions that span the same.
fn inverse_order(basis: &Basis, n: usize, functions: fn(crate::Direction, &mut [f64])) -> Result<Matrix> {
    // Columns are the functions in the basis; its inverse takes coefficients the other way.
    let forward = refit(basis, n, functions)?;
    let inverse = Qr::new(&forward).pseudo_inverse();
    Ok(Matrix::from_fn(n, n, |r, c| {
        let v = inverse[(r, c)];
        if (v - v.round()).abs() < 1e-10 { v.round() } else { v }
    }))
}

/// The bytes of a folder, and their scales.
struct Coded {
    kind: &'static str,
    color: &'static str,
    size: Size,
    planes: usize,
    scale: Vec<f64>,
    bias: Vec<f64>,
    pictures: Vec<Picture3>,
    lights: Vec<f64>,
}

impl Coded {
    fn of(field: &ReflectanceField, kind: &'static str, matrix: &Matrix, job: &Job) -> Result<Self> {
        let (n, size) = (field.basis().len(), field.size());
        let is_product = field.layout().is_product();
        let planes = if is_product { 3 + n } else { 3 * n };
        job.check("the planes of the web folder", size, (planes + 12) as u64)?;
        let plane = |k: usize| Self::plane(field, matrix, k, is_product);
        let coded: Vec<(Vec<u8>, f64, f64)> = parallel::map(0..planes, plane);
        let pictures = coded.chunks(3).map(|three| {
            let byte = |texel: usize, c: usize| three.get(c).map_or(0, |(bytes, ..)| bytes[texel]);
            (0..size.texels()).flat_map(|texel| (0..3).map(move |c| byte(texel, c))).collect::<Vec<u8>>()
        });
        let padded = planes.next_multiple_of(3);
        let list = |number: fn(&(Vec<u8>, f64, f64)) -> f64, other: f64| {
            coded.iter().map(number).chain(std::iter::repeat(other)).take(padded).collect::<Vec<f64>>()
        };
        Ok(Self {
            kind,
            color: if is_product { "lrgb" } else { "rgb" },
            size,
            planes,
            scale: list(|(_, scale, _)| *scale, 1.0),
            bias: list(|(.., bias)| *bias, 0.0),
            pictures: pictures.collect(),
            lights: field.lights().iter().flat_map(|light| light.to_array()).collect(),
        })
    }

    /// The bytes, the scale and the bias of coefficient `k` of the folder.
    fn plane(field: &ReflectanceField, matrix: &Matrix, k: usize, is_product: bool) -> (Vec<u8>, f64, f64) {
        let (n, planes) = (field.basis().len(), field.coefficients());
        if is_product && k < 3 {
            return (planes.plane(n + k).iter().map(|&v| code8(v)).collect(), 1.0, 0.0);
        }
        let (channel, function) = if is_product { (0, k - 3) } else { (k % 3, k / 3) };
        let channel = if *field.layout() == PlaneLayout::LUMINANCE { 0 } else { channel };
        let mut values = vec![0f32; field.size().texels()];
        for (j, &factor) in matrix.row(function).iter().enumerate().filter(|(_, factor)| **factor != 0.0) {
            let from = planes.plane(channel * n + j);
            values.iter_mut().zip(from).for_each(|(out, &v)| *out += factor as f32 * v);
        }
        let (step, bias) = quantise::choose(values.iter().map(|&v| (v, 1.0)));
        let encoding = PtmEncoding { scale: [step; 6], bias: [bias; 6] };
        let bytes = values.iter().map(|&v| nearest_byte(encoding.position(0, v))).collect();
        // (byte - bias) step / 255 = (byte / 255 - bias / 255) step
        (bytes, f64::from(step), f64::from(bias) / 255.0)
    }

    fn info(&self, quality: u8) -> String {
        let Size { width, height } = self.size;
        let info = json!({
            "width": width,
            "height": height,
            "format": "jpg",
            "type": self.kind,
            "colorspace": self.color,
            "colorprofile": "sRGB",
            "nplanes": self.planes,
            "quality": quality,
            "lights": self.lights,
            "materials": [{ "scale": self.scale, "bias": self.bias }],
        });
        format!("{info:#}\n")
    }
}

/// The levels of a picture, from the coarsest: each texel is the mean of four.
fn pyramid(picture: &Picture3, size: Size) -> Vec<(Size, Picture3)> {
    let mut all = vec![(size, picture.clone())];
    for &half in levels(size, TILE_SIDE).iter().rev().skip(1) {
        let (from, texels) = &all[all.len() - 1];
        let texel = |x: usize, y: usize, c: usize| {
            let at = |dx: usize, dy: usize| {
                let (x, y) = ((2 * x + dx).min(from.width - 1), (2 * y + dy).min(from.height - 1));
                u32::from(texels[3 * (y * from.width + x) + c])
            };
            ((at(0, 0) + at(1, 0) + at(0, 1) + at(1, 1) + 2) / 4) as u8
        };
        let places = (0..half.height).flat_map(|y| (0..half.width).map(move |x| (x, y)));
        let mean = places.flat_map(|(x, y)| [0, 1, 2].map(|c| texel(x, y, c))).collect();
        all.push((half, mean));
    }
    all.reverse();
    all
}

/// Column and row of a tile, and its file.
type PlacedTile = ((usize, usize), Vec<u8>);

/// The JPEG files of the tiles of a level, row by row.
fn tiles_of(picture: &Picture3, size: Size, quality: u8) -> Result<Vec<PlacedTile>> {
    let grid = TileGrid { size, side: TILE_SIDE, overlap: 0 };
    let places = (0..grid.down()).flat_map(|y| (0..grid.across()).map(move |x| (x, y)));
    let tile = |(x, y): (usize, usize)| {
        let ((left, across), (top, down)) = (grid.span(x, size.width), grid.span(y, size.height));
        let rows = (top..top + down).flat_map(|row| &picture[3 * (row * size.width + left)..][..3 * across]);
        let samples: Vec<u8> = rows.copied().collect();
        Ok(((x, y), jpeg::encode(&samples, Size::new(across, down), 3, quality)?))
    };
    parallel::try_map(places, tile)
}

fn deepzoom(coded: &Coded, quality: u8, job: &Job, store: &mut StoreFile<'_>) -> Result<()> {
    let Size { width, height } = coded.size;
    for (k, picture) in coded.pictures.iter().enumerate() {
        let text = format!(
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<Image xmlns=\"http://schemas.microsoft.com/deepzoom/2008\" \
             Format=\"jpg\" Overlap=\"0\" TileSize=\"{TILE_SIDE}\">\n  <Size Height=\"{height}\" Width=\"{width}\"/>\n\
             </Image>\n"
        );
        store(&format!("plane_{k}.dzi"), text.as_bytes())?;
        for (level, (size, picture)) in pyramid(picture, coded.size).iter().enumerate() {
            job.proceed()?;
            for ((x, y), bytes) in tiles_of(picture, *size, quality)? {
                store(&format!("plane_{k}_files/{level}/{x}_{y}.jpg"), &bytes)?;
            }
        }
    }
    Ok(())
}

/// The tiles of some pictures in one file, those of a place together, and their offsets in another.
fn archive(
    name: &str,
    pictures: &[&Picture3],
    size: Size,
    quality: u8,
    job: &Job,
    store: &mut StoreFile<'_>,
) -> Result<()> {
    let pyramids: Vec<_> = pictures.iter().map(|picture| pyramid(picture, size)).collect();
    let count = pyramids.first().map_or(0, Vec::len);
    let (mut bytes, mut offsets) = (Vec::new(), vec![0]);
    for level in 0..count {
        job.proceed()?;
        let of_plane =
            |pyramid: &Vec<(Size, Picture3)>| tiles_of(&pyramid[level].1, pyramid[level].0, quality);
        let tiles: Vec<_> = pyramids.iter().map(of_plane).collect::<Result<_>>()?;
        for place in 0..tiles[0].len() {
            for plane in &tiles {
                bytes.extend_from_slice(&plane[place].1);
                offsets.push(bytes.len());
            }
        }
    }
    let mut index = json!({
        "tilesize": TILE_SIDE,
        "overlap": 0,
        "format": "jpg",
        "width": size.width,
        "height": size.height,
        "nlevels": count,
        "offsets": offsets,
    });
    if pictures.len() > 1 || name == "planes" {
        index["stride"] = json!(pictures.len());
        index["mode"] = json!("interleaved");
    }
    store(&format!("{name}.tzi"), format!("{index}\n").as_bytes())?;
    store(&format!("{name}.tzb"), &bytes)
}
