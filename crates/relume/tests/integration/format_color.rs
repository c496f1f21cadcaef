//! Colour spaces that files name: sRGB leaves every code, others are converted with a remark, data is left
//! alone.

use image::codecs::jpeg::JpegEncoder;
use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder};
use relume::format::{decode_raster, open};
use relume::{Job, Raster, Samples};

const SRGB: [&[u8]; 2] =
    [include_bytes!("../data/icc/sRGB-v2-micro.icc"), include_bytes!("../data/icc/sRGB-v4.icc")];
const ADOBE: &[u8] = include_bytes!("../data/icc/AdobeCompat-v2.icc");
const P3: &[u8] = include_bytes!("../data/icc/DisplayP3-v4.icc");
const GREY: &[u8] = include_bytes!("../data/icc/sGrey-v4.icc");

const TEXELS: [u8; 12] = [0, 0, 0, 255, 255, 255, 200, 100, 50, 10, 20, 200];

fn png_of(texels: &[u8], color: ExtendedColorType, profile: Option<&[u8]>) -> Vec<u8> {
    let mut file = Vec::new();
    let mut encoder = PngEncoder::new(&mut file);
    if let Some(profile) = profile {
        encoder.set_icc_profile(profile.to_vec()).unwrap();
    }
    let width = texels.len() as u32 * 8 / u32::from(color.bits_per_pixel());
    encoder.write_image(texels, width, 1, color).unwrap();
    file
}

/// The file with one more chunk after its header.
fn with_chunk(file: &[u8], kind: &[u8; 4], data: &[u8]) -> Vec<u8> {
    let body = [&kind[..], data].concat();
    let crc = crc32fast::hash(&body).to_be_bytes();
    [&file[..33], &(data.len() as u32).to_be_bytes(), &body, &crc, &file[33..]].concat()
}

fn gamma(hundred_thousandths: u32) -> [u8; 4] {
    hundred_thousandths.to_be_bytes()
}

/// The picture, and what is remarked on it.
fn read(file: &[u8]) -> (Raster, Vec<String>) {
    let job = Job::default();
    (decode_raster(file, &job).unwrap(), job.remarks())
}

fn codes(raster: &Raster) -> Vec<u8> {
    let Samples::U8(codes) = raster.samples() else { panic!("{raster:?}") };
    codes.clone()
}

#[test]
fn profiles_of_srgb_leave_every_code_without_a_word() {
    for profile in SRGB {
        let (raster, remarks) = read(&png_of(&TEXELS, ExtendedColorType::Rgb8, Some(profile)));
        assert_eq!((codes(&raster), remarks), (TEXELS.to_vec(), vec![]));
    }
    let (raster, remarks) = read(&png_of(&TEXELS, ExtendedColorType::L8, Some(GREY)));
    assert_eq!((codes(&raster), remarks), (TEXELS.to_vec(), vec![]));
}

#[test]
fn adobe_rgb_becomes_srgb() {
    let (raster, remarks) = read(&png_of(&TEXELS, ExtendedColorType::Rgb8, Some(ADOBE)));
    // Adobe RGB (1998), 4.3.5: power 563/256; its red and blue in terms of sRGB with the common green.
    let linear = |code: u8| (f64::from(code) / 255.0).powf(563.0 / 256.0);
    let encoded = |v: f64| {
        let v = v.clamp(0.0, 1.0);
        255.0 * if v <= 0.0031308 { 12.92 * v } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 }
    };
    for (found, texel) in codes(&raster).chunks(3).zip(TEXELS.chunks(3)) {
        let [r, g, b] = [0, 1, 2].map(|c| linear(texel[c]));
        let expected = [1.39836 * r - 0.39836 * g, g, -0.04293 * g + 1.04293 * b].map(encoded);
        for (found, expected) in found.iter().zip(expected) {
            assert!((f64::from(*found) - expected).abs() < 1.6, "{texel:?}: {found} {expected}");
        }
    }
    assert!(remarks.len() == 1 && remarks[0].contains("converted from"), "{remarks:?}");
}

#[test]
fn a_jpeg_profile_is_applied_as_well() {
    let texels: Vec<u8> = [200, 100, 50].repeat(64);
    let jpeg = |profile: Option<&[u8]>| {
        let mut file = Vec::new();
        let mut encoder = JpegEncoder::new_with_quality(&mut file, 100);
        profile.into_iter().for_each(|profile| encoder.set_icc_profile(profile.to_vec()).unwrap());
        encoder.write_image(&texels, 8, 8, ExtendedColorType::Rgb8).unwrap();
        file
    };
    let (plain, remarks) = read(&jpeg(None));
    assert!(remarks.is_empty());
    assert_eq!(read(&jpeg(Some(SRGB[1]))).0, plain);
    let (converted, remarks) = read(&jpeg(Some(P3)));
    assert!(codes(&converted)[0] > codes(&plain)[0] + 5, "the red of P3 is stronger");
    assert!(remarks[0].contains("converted from"), "{remarks:?}");
}

#[test]
fn png_chunks_count_by_their_precedence() {
    let plain = png_of(&TEXELS, ExtendedColorType::Rgb8, None);
    let linear = with_chunk(&plain, b"gAMA", &gamma(100_000));
    let (raster, remarks) = read(&linear);
    assert_eq!(codes(&raster)[6], 229, "linear 200 is encoded");
    assert!(remarks[0].contains("power 1.00"), "{remarks:?}");
    let (raster, remarks) = read(&with_chunk(&linear, b"sRGB", &[0]));
    assert_eq!((codes(&raster), remarks.len()), (TEXELS.to_vec(), 0), "sRGB before gAMA");
    let usual = with_chunk(&plain, b"gAMA", &gamma(45_455));
    assert_eq!(codes(&read(&usual).0), TEXELS, "the customary power of sRGB");
    let tagged = png_of(&TEXELS, ExtendedColorType::Rgb8, Some(P3));
    let (raster, _) = read(&with_chunk(&tagged, b"gAMA", &gamma(45_455)));
    assert_ne!(codes(&raster), TEXELS, "iCCP before gAMA");
    let (raster, remarks) = read(&with_chunk(&tagged, b"cICP", &[1, 13, 0, 1]));
    assert_eq!((codes(&raster), remarks.len()), (TEXELS.to_vec(), 0), "cICP before iCCP");
}

#[test]
fn a_damaged_profile_is_said_once_and_the_values_are_srgb() {
    let plain = png_of(&TEXELS, ExtendedColorType::Rgb8, None);
    let files = [
        png_of(&TEXELS, ExtendedColorType::Rgb8, Some(&P3[..200])),
        with_chunk(&plain, b"iCCP", b"a\0\0junk"),
    ];
    for file in files {
        let (raster, remarks) = read(&file);
        assert_eq!(codes(&raster), TEXELS);
        assert!(remarks.len() == 1 && remarks[0].contains("taken as sRGB"), "{remarks:?}");
    }
}

#[test]
fn data_and_registered_images_are_never_converted() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("normals.png");
    std::fs::write(&path, png_of(&TEXELS, ExtendedColorType::Rgb8, Some(P3))).unwrap();
    let job = Job::default();
    assert_eq!(codes(&open(&path, &job).unwrap().into_data().unwrap()), TEXELS);
    assert!(job.remarks().is_empty(), "{:?}", job.remarks());
    let copied = open(&path, &job).unwrap().into_registered().unwrap();
    assert_eq!(copied.field.coefficients().at(0, 2, 0), 200.0 / 255.0);
    assert!(job.remarks()[0].contains("copied as stored"), "{:?}", job.remarks());
    assert_ne!(codes(&open(&path, &job).unwrap().into_raster().unwrap()), TEXELS);
}
