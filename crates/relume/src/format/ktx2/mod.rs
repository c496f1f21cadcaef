//! KTX2 textures for engines: all levels of detail, uncompressed or in blocks of BC7.
//!
//! "KTX File Format Specification", version 2.0 (Khronos Group, 2020), with a basic data format descriptor ("Khronos Data
//! Format Specification" 1.3). Written only: colours as `R8G8B8A8_SRGB` or `BC7_SRGB_BLOCK`, data of three or four channels as
//! `R8G8B8A8_UNORM` or `BC7_UNORM_BLOCK`, data of one channel as `R8_UNORM` or `BC7_UNORM_BLOCK`. Rows go from the top
//! (`KTXorientation` is `rd`), nothing is supercompressed.

mod blocks;
mod descriptor;
mod levels;
mod mode6;

use serde::Serialize;

use crate::error::Result;
use crate::job::Job;
use crate::names::named;
use crate::planes::Planes;
use crate::size::Size;
use descriptor::TexelFormat;

/// How textures of a material are stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum TextureFormat {
    /// PNG.
    #[default]
    Png,
    /// KTX2 with uncompressed levels of 8 bits.
    Ktx2,
    /// KTX2 with levels in blocks of BC7.
    Bc7,
}

named!(TextureFormat { Png => "png", Ktx2 => "ktx2", Bc7 => "bc7" });

impl TextureFormat {
    /// The extension of its files.
    pub fn extension(self) -> &'static str {
        if self == Self::Png { "png" } else { "ktx2" }
    }
}

/// What the texels of a texture mean, on which their average depends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum KtxContent {
    /// Colours encoded as sRGB, averaged in linear light; a fourth plane is opacity.
    Color,
    /// Unit vectors packed to 0..1, averaged as directions.
    Normals,
    /// Anything else.
    Data,
}

/// The first bytes of every file.
const IDENTIFIER: [u8; 12] = *b"\xabKTX 20\xbb\r\n\x1a\n";
/// The bytes before the index of levels.
const HEADER_BYTES: usize = 80;
/// The bytes of a level in the index.
const LEVEL_BYTES: usize = 24;
/// The bytes of a texel while levels are made, over its planes.
const WORKING_BYTES: u64 = 24;

/// The bytes of a texel while the levels of so many channels are made, beside the texture.
pub fn bytes_per_texel(channels: usize) -> u64 {
    WORKING_BYTES + 8 * channels as u64
}

/// The file of a texture with all levels down to one texel; planes hold values from 0 to 1.
///
/// # Errors
/// The limits, and a cancelled job.
///
/// # Panics
/// When there are no planes or more than four, or the storage is PNG.
pub fn encode(planes: &Planes, content: KtxContent, storage: TextureFormat, job: &Job) -> Result<Vec<u8>> {
    assert!((1..=4).contains(&planes.count()), "one to four channels");
    assert_ne!(storage, TextureFormat::Png, "PNG is no KTX2");
    job.check("the levels of a texture", planes.size(), bytes_per_texel(planes.count()))?;
    let format = TexelFormat::of(planes.count(), content, storage);
    let mut levels = Vec::new();
    let mut finer: Option<Planes> = None;
    loop {
        job.proceed()?;
        let level = finer.as_ref().unwrap_or(planes);
        levels.push(format.bytes(level));
        if level.size() == Size::new(1, 1) {
            break;
        }
        finer = Some(levels::halved(level, content));
    }
    Ok(container(planes.size(), format, &levels))
}

/// The header, the index, the descriptor, the keys, and the levels from the coarsest on.
fn container(size: Size, format: TexelFormat, levels: &[Vec<u8>]) -> Vec<u8> {
    let (descriptor, keys) = (format.descriptor(), key_values());
    let descriptor_at = HEADER_BYTES + LEVEL_BYTES * levels.len();
    let keys_at = descriptor_at + descriptor.len();
    let mut places = vec![0; levels.len()];
    let mut end = keys_at + keys.len();
    for (place, level) in places.iter_mut().zip(levels).rev() {
        *place = end.next_multiple_of(format.alignment());
        end = *place + level.len();
    }
    let mut file = IDENTIFIER.to_vec();
    let words = [
        format.vulkan(),
        1,
        size.width as u32,
        size.height as u32,
        0,
        0,
        1,
        levels.len() as u32,
        0,
        descriptor_at as u32,
        descriptor.len() as u32,
        keys_at as u32,
        keys.len() as u32,
    ];
    file.extend(words.iter().flat_map(|word: &u32| word.to_le_bytes()));
    // No global data of a supercompression.
    file.extend([0; 16]);
    for (place, level) in places.iter().zip(levels) {
        let bytes = level.len() as u64;
        file.extend([*place as u64, bytes, bytes].iter().flat_map(|number| number.to_le_bytes()));
    }
    file.extend(descriptor);
    file.extend(keys);
    file.reserve(end - file.len());
    for (place, level) in places.iter().zip(levels).rev() {
        file.resize(*place, 0);
        file.extend(level);
    }
    file
}

/// The keys in their order, each with its length and padded to four bytes.
fn key_values() -> Vec<u8> {
    let writer = format!("relume {}", env!("CARGO_PKG_VERSION"));
    let mut bytes = Vec::new();
    for (key, value) in [("KTXorientation", "rd"), ("KTXwriter", &writer)] {
        let entry = [key.as_bytes(), b"\0", value.as_bytes(), b"\0"].concat();
        bytes.extend((entry.len() as u32).to_le_bytes());
        bytes.extend(&entry);
        bytes.resize(bytes.len().next_multiple_of(4), 0);
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::random::{Purpose, Stream};
    use crate::space::linear_from_srgb;

    fn planes(size: Size, count: usize) -> Planes {
        let mut stream = Stream::new(3, Purpose::Sample, [size.width as u64]);
        let values = (0..size.texels() * count).map(|_| stream.unit() as f32).collect();
        Planes::from_vec(size, count, values).unwrap()
    }

    /// A file as its specification reads it.
    struct ReadTexture {
        format: u32,
        size: [u32; 2],
        /// The bytes of each level, the finest first.
        levels: Vec<Vec<u8>>,
        descriptor: Vec<u8>,
    }

    fn word(bytes: &[u8], at: usize) -> u32 {
        u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap())
    }

    fn long(bytes: &[u8], at: usize) -> usize {
        u64::from_le_bytes(bytes[at..at + 8].try_into().unwrap()) as usize
    }

    fn read(file: &[u8]) -> ReadTexture {
        assert_eq!(&file[..12], b"\xabKTX 20\xbb\r\n\x1a\n");
        assert_eq!(word(file, 16), 1, "the size of a number");
        assert_eq!([word(file, 28), word(file, 32), word(file, 36)], [0, 0, 1], "depth, layers, faces");
        let count = word(file, 40) as usize;
        assert_eq!(word(file, 44), 0, "no supercompression");
        assert_eq!((long(file, 64), long(file, 72)), (0, 0));
        let mut levels = Vec::new();
        let mut last = file.len();
        for level in 0..count {
            let entry = 80 + 24 * level;
            let (at, length) = (long(file, entry), long(file, entry + 8));
            assert_eq!(length, long(file, entry + 16));
            // The finest level is the last in the file.
            assert_eq!(at + length, if level == 0 { file.len() } else { at + length });
            assert!(at + length <= last && at % 4 == 0, "level {level}");
            last = at;
            levels.push(file[at..at + length].to_vec());
        }
        let at = word(file, 48) as usize;
        let descriptor = file[at..at + word(file, 52) as usize].to_vec();
        assert_eq!(word(&descriptor, 0) as usize, descriptor.len());
        let keys = &file[word(file, 56) as usize..][..word(file, 60) as usize];
        assert!(keys.windows(18).any(|w| w == b"KTXorientation\0rd\0"));
        ReadTexture { format: word(file, 12), size: [word(file, 20), word(file, 24)], levels, descriptor }
    }

    fn encoded(planes: &Planes, content: KtxContent, storage: TextureFormat) -> ReadTexture {
        read(&encode(planes, content, storage, &Job::default()).unwrap())
    }

    #[test]
    fn uncompressed_levels_hold_the_codes_and_their_averages() {
        for (width, height) in [(1, 1), (2, 2), (13, 7), (64, 32)] {
            let size = Size::new(width, height);
            for (count, content, format) in
                [(3, KtxContent::Color, 43), (4, KtxContent::Data, 37), (1, KtxContent::Data, 9)]
            {
                let from = planes(size, count);
                let found = encoded(&from, content, TextureFormat::Ktx2);
                assert_eq!((found.format, found.size), (format, [width as u32, height as u32]));
                assert_eq!(found.levels.len(), width.max(height).ilog2() as usize + 1);
                let stored = if count == 1 { 1 } else { 4 };
                for (texel, bytes) in found.levels[0].chunks_exact(stored).enumerate() {
                    for (k, &byte) in bytes.iter().enumerate().take(count) {
                        assert_eq!(byte, (from.plane(k)[texel] * 255.0).round() as u8);
                    }
                    assert!(count != 3 || bytes[3] == 255);
                }
                assert_eq!(found.levels.last().unwrap().len(), stored);
            }
        }
    }

    #[test]
    fn colours_are_averaged_as_light_and_normals_as_directions() {
        let size = Size::new(2, 2);
        let grey = Planes::from_vec(size, 1, vec![0.0, 1.0, 0.0, 1.0]).unwrap();
        let colors = Planes::from_vec(size, 3, [grey.plane(0); 3].concat()).unwrap();
        let found = encoded(&colors, KtxContent::Color, TextureFormat::Ktx2);
        assert!((linear_from_srgb(f32::from(found.levels[1][0]) / 255.0) - 0.5).abs() < 0.01);
        let found = encoded(&grey, KtxContent::Data, TextureFormat::Ktx2);
        assert_eq!(found.levels[1], [128]);
        // Two slopes of 45 degrees that face each other are level from afar.
        let s = 0.5f32.sqrt();
        let x = [s, -s, s, -s].map(|v| 0.5 * v + 0.5);
        let normals = [&x[..], &[0.5; 4], &[0.5 * s + 0.5; 4]].concat();
        let normals = Planes::from_vec(size, 3, normals).unwrap();
        let found = encoded(&normals, KtxContent::Normals, TextureFormat::Ktx2);
        assert_eq!(found.levels[1], [128, 128, 255, 255]);
    }

    #[test]
    fn descriptors_say_what_the_texels_are() {
        let sampled = |planes: &Planes, content, storage| encoded(planes, content, storage).descriptor;
        let colors = sampled(&planes(Size::new(4, 4), 3), KtxContent::Color, TextureFormat::Ktx2);
        // Version 2, block of 24 bytes and four samples; RGBSDA, BT.709, sRGB.
        assert_eq!((word(&colors, 4), word(&colors, 8)), (0, 2 | (24 + 4 * 16) << 16));
        assert_eq!(&colors[12..24], [1, 1, 2, 0, 0, 0, 0, 0, 4, 0, 0, 0]);
        // Opacity is linear in any case.
        assert_eq!(colors[28 + 3 * 16 + 3], 15 | 0x10);
        let data = sampled(&planes(Size::new(4, 4), 3), KtxContent::Data, TextureFormat::Bc7);
        assert_eq!((data[12], data[14], &data[16..18]), (134, 1, &[3, 3][..]));
        assert_eq!((data[28 + 2], word(&data, 40)), (127, u32::MAX));
    }

    #[test]
    fn blocks_of_bc7_come_back_near_the_texels() {
        let size = Size::new(37, 22);
        let gentle = |k: usize, texel: usize| {
            let (x, y) = ((texel % 37) as f32, (texel / 37) as f32);
            0.5 + 0.4 * (0.1 * x + 0.2 * y + k as f32).sin()
        };
        let values: Vec<f32> = (0..3).flat_map(|k| (0..size.texels()).map(move |t| gentle(k, t))).collect();
        let from = Planes::from_vec(size, 3, values).unwrap();
        let found = encoded(&from, KtxContent::Color, TextureFormat::Bc7);
        assert_eq!((found.format, found.levels.len()), (146, 6));
        let (w, h) = (40, 24);
        assert_eq!(found.levels[0].len(), w * h);
        assert_eq!(found.levels[5].len(), 16);
        let mut back = vec![0; 4 * w * h];
        let variant =
            block_compression::CompressionVariant::BC7(block_compression::BC7Settings::opaque_basic());
        block_compression::decode::decompress_blocks_as_rgba8(
            variant,
            w as u32,
            h as u32,
            &found.levels[0],
            &mut back,
        );
        for texel in 0..size.texels() {
            let at = 4 * (texel / 37 * w + texel % 37);
            for k in 0..3 {
                let difference = f32::from(back[at + k]) - 255.0 * from.plane(k)[texel];
                assert!(difference.abs() < 12.0, "{texel} {k}: {difference}");
            }
        }
    }
}
