//! Pictures from other programs: orientation, alpha, palettes, animations.

use std::io::Cursor;

use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder};
use relume::format::animation::{encode_apng, encode_gif};
use relume::format::{
    Depth, PictureFormat, decode_field, decode_raster, encode_picture, read_field, read_raster,
};
use relume::{ErrorKind, Job, Limits, Picture, Planes, Raster, Samples, Size, Space};

use crate::support::{data, job};

/// The EXIF block of a picture with an orientation: a TIFF header and a single entry.
fn exif(orientation: u8) -> Vec<u8> {
    let mut block = b"MM\0\x2a\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0".to_vec();
    block.extend([orientation, 0, 0, 0, 0, 0, 0]);
    block
}

/// 3 x 2 texels, stored.
const STORED: [u8; 6] = [10, 20, 30, 40, 50, 60];

/// The picture shown by a viewer for each orientation (EXIF 2.3, tag 0x0112), row by row, and its width.
const SHOWN: [([u8; 6], usize); 8] = [
    ([10, 20, 30, 40, 50, 60], 3),
    ([30, 20, 10, 60, 50, 40], 3),
    ([60, 50, 40, 30, 20, 10], 3),
    ([40, 50, 60, 10, 20, 30], 3),
    ([10, 40, 20, 50, 30, 60], 2),
    ([40, 10, 50, 20, 60, 30], 2),
    ([60, 30, 50, 20, 40, 10], 2),
    ([30, 60, 20, 50, 10, 40], 2),
];

#[test]
fn png_pictures_are_turned_as_their_exif_says() {
    for (i, (shown, width)) in SHOWN.into_iter().enumerate() {
        let mut file = Vec::new();
        let mut encoder = PngEncoder::new(&mut file);
        encoder.set_exif_metadata(exif(i as u8 + 1)).unwrap();
        encoder.write_image(&STORED, 3, 2, ExtendedColorType::L8).unwrap();
        let truth = Raster::new(Size::new(width, 6 / width), 1, Samples::U8(shown.to_vec())).unwrap();
        assert_eq!(decode_raster(&file, &job()).unwrap(), truth, "orientation {}", i + 1);
    }
}

#[test]
fn jpeg_pictures_are_turned_as_their_exif_says() {
    // Constant blocks of 8 x 8 survive compression.
    let size = Size::new(24, 16);
    let value = |x: usize, y: usize| f32::from(STORED[y / 8 * 3 + x / 8] * 4) / 255.0;
    let stored = (0..size.texels()).map(|i| value(i % 24, i / 24)).collect();
    let planes = Planes::from_vec(size, 1, stored).unwrap();
    let plain = encode_picture(&Picture { planes, space: Space::Srgb }, PictureFormat::Jpeg { quality: 100 })
        .unwrap();
    for (i, (shown, width)) in SHOWN.into_iter().enumerate() {
        let block = exif(i as u8 + 1);
        let length = (block.len() + 8) as u16;
        let segment = [&[0xff, 0xe1], &length.to_be_bytes()[..], b"Exif\0\0", &block].concat();
        let file = [&plain[..2], &segment, &plain[2..]].concat();
        let raster = decode_raster(&file, &job()).unwrap();
        assert_eq!(raster.size(), Size::new(8 * width, 8 * (6 / width)));
        for (k, expected) in shown.into_iter().enumerate() {
            let (x, y) = (k % width * 8 + 4, k / width * 8 + 4);
            let found = 255.0 * raster.samples().value(raster.size().index(x, y));
            assert!((found - f32::from(expected) * 4.0).abs() < 3.0, "orientation {}: {found}", i + 1);
        }
    }
}

#[test]
fn tiff_pictures_are_turned_as_they_say() {
    for (i, (shown, width)) in SHOWN.into_iter().enumerate() {
        let truth = Raster::new(Size::new(width, 6 / width), 1, Samples::U8(shown.to_vec())).unwrap();
        assert_eq!(decode_raster(&tiff(i as u16 + 1), &job()).unwrap(), truth, "orientation {}", i + 1);
    }
}

/// A little-endian grey TIFF file with one strip and an orientation.
fn tiff(orientation: u16) -> Vec<u8> {
    let entries: [(u16, u16); 9] =
        [(256, 3), (257, 2), (258, 8), (259, 1), (262, 1), (273, 8), (274, orientation), (278, 2), (279, 6)];
    let mut file = b"II\x2a\0\x0e\0\0\0".to_vec();
    file.extend(STORED);
    file.extend((entries.len() as u16).to_le_bytes());
    for (tag, value) in entries {
        file.extend(tag.to_le_bytes());
        file.extend([3, 0, 1, 0, 0, 0]);
        file.extend(value.to_le_bytes());
        file.extend([0, 0]);
    }
    file.extend([0; 4]);
    file
}

#[test]
fn a_bigtiff_picture_is_read() {
    let entries: [(u16, u64); 9] =
        [(256, 3), (257, 2), (258, 8), (259, 1), (262, 1), (273, 16), (277, 1), (278, 2), (279, 6)];
    let mut file = b"II\x2b\0\x08\0\0\0\x18\0\0\0\0\0\0\0".to_vec();
    file.extend(STORED);
    file.extend([0, 0]);
    file.extend((entries.len() as u64).to_le_bytes());
    for (tag, value) in entries {
        file.extend(tag.to_le_bytes());
        file.extend(4u16.to_le_bytes());
        file.extend(1u64.to_le_bytes());
        file.extend(value.to_le_bytes());
    }
    file.extend([0; 8]);
    let truth = Raster::new(Size::new(3, 2), 1, Samples::U8(STORED.to_vec())).unwrap();
    assert_eq!(decode_raster(&file, &job()).unwrap(), truth);
}

#[test]
fn alpha_is_kept_and_palettes_are_expanded() {
    let mut file = Vec::new();
    let texels = [1u8, 2, 3, 200, 4, 5, 6, 0];
    PngEncoder::new(&mut file).write_image(&texels, 2, 1, ExtendedColorType::Rgba8).unwrap();
    let truth = Raster::new(Size::new(2, 1), 3, Samples::U8(vec![1, 2, 3, 4, 5, 6])).unwrap();
    let truth = truth.with_opacity(Samples::U8(vec![200, 0])).unwrap();
    assert_eq!(decode_raster(&file, &job()).unwrap(), truth);

    let mut file = Vec::new();
    PngEncoder::new(&mut file).write_image(&[9, 255, 7, 3], 2, 1, ExtendedColorType::La8).unwrap();
    let truth = Raster::new(Size::new(2, 1), 1, Samples::U8(vec![9, 7])).unwrap();
    let truth = truth.with_opacity(Samples::U8(vec![255, 3])).unwrap();
    assert_eq!(decode_raster(&file, &job()).unwrap(), truth);

    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, 4, 1);
    encoder.set_color(png::ColorType::Indexed);
    encoder.set_depth(png::BitDepth::Two);
    encoder.set_palette(vec![0, 0, 0, 10, 20, 30, 40, 50, 60]);
    encoder.write_header().unwrap().write_image_data(&[0b0110_0001]).unwrap();
    let truth = vec![10, 20, 30, 40, 50, 60, 0, 0, 0, 10, 20, 30];
    assert_eq!(
        decode_raster(&file, &job()).unwrap(),
        Raster::new(Size::new(4, 1), 3, Samples::U8(truth)).unwrap()
    );
}

#[test]
fn tiff_floats_are_linear() {
    let texels: Vec<f32> = vec![0.0, 0.5, 1.0, 2.0, -1.0, 1e-3];
    let bytes: Vec<u8> = texels.iter().flat_map(|v| v.to_ne_bytes()).collect();
    let mut file = Cursor::new(Vec::new());
    image::codecs::tiff::TiffEncoder::new(&mut file)
        .write_image(&bytes, 2, 1, ExtendedColorType::Rgb32F)
        .unwrap();
    let read = decode_raster(file.get_ref(), &job()).unwrap();
    assert_eq!(read, Raster::new(Size::new(2, 1), 3, Samples::F32(texels)).unwrap());
}

#[test]
fn errors_name_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("photo.png");
    let missing = read_raster(&path, &job()).unwrap_err();
    assert_eq!((missing.kind(), missing.path()), (ErrorKind::Io, Some(path.as_path())));
    for (content, kind) in [(&b""[..], ErrorKind::Invalid), (b"GIF89a..", ErrorKind::Unsupported)] {
        std::fs::write(&path, content).unwrap();
        let error = read_field(&path, &job()).unwrap_err();
        assert_eq!((error.kind(), error.path()), (kind, Some(path.as_path())));
    }
    let error = read_raster(folder.path(), &job()).unwrap_err();
    assert!(error.message().contains("folder"), "{error}");
    std::fs::write(&path, [0; 100]).unwrap();
    let error = read_raster(&path, &Job::new(Limits { max_bytes: 99, max_side: 9 })).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Limit);
}

#[test]
fn contents_decide_not_extensions() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("wrong.jpg");
    let picture = Picture { planes: Planes::zeros(Size::new(3, 3), 3), space: Space::Srgb };
    std::fs::write(&path, encode_picture(&picture, PictureFormat::Png(Depth::Sixteen)).unwrap()).unwrap();
    assert!(matches!(read_raster(&path, &job()).unwrap().samples(), Samples::U16(_)));
}

fn frames(channels: usize) -> Vec<Picture> {
    let size = Size::new(20, 10);
    let value = |f: usize, i: usize| ((i * 7 + f * 31) % 256) as f32 / 255.0;
    let planes = |f: usize| (0..size.texels() * channels).map(|i| value(f, i)).collect();
    (0..4)
        .map(|f| Picture { planes: Planes::from_vec(size, channels, planes(f)).unwrap(), space: Space::Srgb })
        .collect()
}

#[test]
fn animated_png_keeps_every_frame() {
    for channels in [1, 3] {
        let frames = frames(channels);
        let file = encode_apng(&frames, 24).unwrap();
        let mut reader = png::Decoder::new(Cursor::new(&file)).read_info().unwrap();
        let control = *reader.info().animation_control().unwrap();
        assert_eq!((control.num_frames, control.num_plays), (4, 0));
        for frame in &frames {
            let mut texels = vec![0; reader.output_buffer_size().unwrap()];
            reader.next_frame(&mut texels).unwrap();
            let delay = reader.info().frame_control().unwrap();
            assert_eq!((delay.delay_num, delay.delay_den), (1, 24));
            let truth = encode_picture(frame, PictureFormat::Png(Depth::Eight)).unwrap();
            let truth = decode_raster(&truth, &job()).unwrap();
            assert_eq!(truth.samples(), &Samples::U8(texels));
        }
        let still = decode_raster(&file, &job()).unwrap();
        assert_eq!(still.to_picture(Space::Srgb), frames[0], "readers of stills see the first frame");
    }
}

#[test]
fn animated_gif_repeats_and_keeps_greys() {
    for channels in [1, 3] {
        let frames = frames(channels);
        let file = encode_gif(&frames, 30).unwrap();
        assert_eq!(file, encode_gif(&frames, 30).unwrap());
        let mut options = gif::DecodeOptions::new();
        options.set_color_output(gif::ColorOutput::RGBA);
        let mut decoder = options.read_info(Cursor::new(&file)).unwrap();
        let mut delays = 0;
        for frame in &frames {
            let read = decoder.read_next_frame().unwrap().unwrap();
            delays += read.delay;
            let (mut sum, mut worst) = (0.0, 0.0f32);
            for (i, texel) in read.buffer.chunks_exact(4).enumerate() {
                for (c, plane) in frame.planes.iter().enumerate() {
                    let error = (f32::from(texel[c]) - 255.0 * plane[i]).abs();
                    sum += error;
                    worst = worst.max(error);
                }
            }
            let mean = sum / (frame.planes.as_slice().len() as f32);
            assert!(if channels == 1 { worst < 0.01 } else { mean < 8.0 }, "{channels}: {mean} {worst}");
        }
        assert!(decoder.read_next_frame().unwrap().is_none());
        assert_eq!((decoder.repeat(), delays), (gif::Repeat::Infinite, 13));
    }
}

#[test]
fn animations_refuse_what_they_cannot_show() {
    let mut uneven = frames(3);
    uneven.push(Picture { planes: Planes::zeros(Size::new(9, 9), 3), space: Space::Srgb });
    for encode in [encode_apng, encode_gif] {
        assert!(encode(&[], 10).is_err());
        assert!(encode(&frames(3), 0).is_err());
        assert!(encode(&uneven, 10).unwrap_err().message().contains("frame 4"));
    }
    assert!(encode_gif(&frames(1), 51).is_err());
}

#[test]
fn photographs_are_read() {
    for (path, size, channels) in [
        ("captures/wool", Size::new(256, 256), 3),
        ("materials/bark/albedo.jpg", Size::new(1024, 1024), 3),
        ("textures/brick.png", Size::new(512, 512), 1),
    ] {
        let Some(mut path) = data(path) else { continue };
        if path.is_dir() {
            let entries = std::fs::read_dir(&path).unwrap().map(|entry| entry.unwrap().path());
            let mut pictures: Vec<_> =
                entries.filter(|p| p.extension().is_some_and(|e| e == "png")).collect();
            pictures.sort();
            path = pictures.swap_remove(0);
        }
        let raster = read_raster(&path, &Job::default()).unwrap();
        assert_eq!((raster.size(), raster.channels()), (size, channels), "{}", path.display());
        assert!(matches!(raster.samples(), Samples::U8(_)));
        let field = decode_field(&std::fs::read(&path).unwrap(), &Job::default()).unwrap().field;
        assert_eq!((field.size(), field.space()), (size, Space::Srgb));
    }
}
