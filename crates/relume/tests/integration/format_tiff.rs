//! TIFF files of other programs: greys and colours of every depth, with opacity, interleaved or in planes.

use relume::format::decode_raster;
use relume::{ErrorKind, Job, Limits, Raster, Result, Samples, Size};

/// A little-endian TIFF file of 3 x 2 texels, without compression.
struct TiffFile {
    bits: u16,
    samples: u16,
    /// 1 unsigned, 2 signed, 3 floats.
    format: u16,
    /// 0 white is zero, 1 black is zero, 2 RGB, 3 palette, 5 CMYK, 6 YCbCr.
    photometric: u16,
    extra: Option<u16>,
    in_planes: bool,
    data: Vec<u8>,
}

const SIZE: Size = Size::new(3, 2);

impl TiffFile {
    fn new(samples: u16, format: u16, bits: u16, data: Vec<u8>) -> Self {
        let photometric = if samples < 3 { 1 } else { 2 };
        Self { bits, samples, format, photometric, extra: None, in_planes: false, data }
    }

    fn with_extra(self, kind: u16) -> Self {
        Self { extra: Some(kind), ..self }
    }

    fn bytes(&self) -> Vec<u8> {
        let strips = if self.in_planes { self.samples } else { 1 };
        let strip = self.data.len() as u32 / u32::from(strips);
        let offsets = (0..u32::from(strips)).map(|k| 8 + k * strip).collect();
        let all = |value: u16| vec![u32::from(value); self.samples.into()];
        let mut entries: Vec<(u16, Vec<u32>)> = vec![
            (256, vec![3]),
            (257, vec![2]),
            (258, all(self.bits)),
            (259, vec![1]),
            (262, vec![self.photometric.into()]),
            (273, offsets),
            (277, vec![self.samples.into()]),
            (278, vec![2]),
            (279, vec![strip; strips.into()]),
            (284, vec![if self.in_planes { 2 } else { 1 }]),
        ];
        entries.extend(self.extra.map(|kind| (338, vec![u32::from(kind)])));
        entries.push((339, all(self.format)));
        let start = 8 + self.data.len() as u32;
        let mut file = [b"II\x2a\0", &start.to_le_bytes()[..], &self.data].concat();
        let mut values = Vec::new();
        let beyond = start + 2 + 12 * entries.len() as u32 + 4;
        file.extend((entries.len() as u16).to_le_bytes());
        for (tag, entry) in entries {
            let kind: u16 = if entry.len() == 1 { 3 } else { 4 };
            file.extend([tag.to_le_bytes(), kind.to_le_bytes()].concat());
            file.extend((entry.len() as u32).to_le_bytes());
            match entry[..] {
                [only] => file.extend(only.to_le_bytes()),
                _ => {
                    file.extend((beyond + values.len() as u32).to_le_bytes());
                    values.extend(entry.iter().flat_map(|v| v.to_le_bytes()));
                }
            }
        }
        file.extend([0; 4]);
        file.extend(values);
        file
    }

    fn read(&self) -> Result<Raster> {
        decode_raster(&self.bytes(), &Job::default())
    }
}

fn floats(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

const GREYS: [f32; 6] = [0.0, 0.25, 0.5, 1.0, 2.0, -1.0];
const ALPHAS: [f32; 6] = [1.0, 0.0, 0.5, 1.0, 1.0, 1.0];

fn grey_alpha() -> Vec<u8> {
    floats(&GREYS.into_iter().zip(ALPHAS).flat_map(|(grey, alpha)| [grey, alpha]).collect::<Vec<_>>())
}

#[test]
fn grey_floats_are_read_with_and_without_opacity() {
    let truth = Raster::new(SIZE, 1, Samples::F32(GREYS.to_vec())).unwrap();
    assert_eq!(TiffFile::new(1, 3, 32, floats(&GREYS)).read().unwrap(), truth);
    let translucent = truth.with_opacity(Samples::F32(ALPHAS.to_vec())).unwrap();
    assert_eq!(TiffFile::new(2, 3, 32, grey_alpha()).with_extra(2).read().unwrap(), translucent);
    let associated = TiffFile::new(2, 3, 32, grey_alpha()).with_extra(1).read().unwrap();
    assert_eq!(associated.samples(), &Samples::F32(vec![0.0, 0.25, 1.0, 1.0, 2.0, -1.0]));
    assert_eq!(associated.opacity(), translucent.opacity());
}

#[test]
fn doubles_and_halves_are_floats_and_integers_of_32_bits_are_rounded() {
    let doubles = GREYS.iter().flat_map(|v| f64::from(*v).to_le_bytes()).collect();
    let halves = GREYS.iter().flat_map(|v| half::f16::from_f32(*v).to_le_bytes()).collect();
    let truth = Raster::new(SIZE, 1, Samples::F32(GREYS.to_vec())).unwrap();
    assert_eq!(TiffFile::new(1, 3, 64, doubles).read().unwrap(), truth);
    assert_eq!(TiffFile::new(1, 3, 16, halves).read().unwrap(), truth);
    let integers = [0, 1, 65537, 1 << 31, u32::MAX - 1, u32::MAX];
    let file = TiffFile::new(1, 1, 32, integers.iter().flat_map(|v| v.to_le_bytes()).collect());
    let job = Job::default();
    let raster = decode_raster(&file.bytes(), &job).unwrap();
    assert_eq!(raster.samples(), &Samples::U16(vec![0, 0, 1, 32768, 65535, 65535]));
    assert!(job.remarks()[0].contains("rounded to 16 bits"));
}

#[test]
fn planes_are_interleaved() {
    let bytes: Vec<u8> = (0..24).collect();
    let in_planes = |samples: u16| {
        let data = (0..usize::from(samples)).flat_map(|c| (0..6).map(move |t| (t * 4 + c) as u8)).collect();
        TiffFile { in_planes: true, ..TiffFile::new(samples, 1, 8, data) }
    };
    let truth =
        Raster::new(SIZE, 3, Samples::U8(bytes.chunks(4).flat_map(|texel| &texel[..3]).copied().collect()))
            .unwrap();
    assert_eq!(in_planes(3).read().unwrap(), truth);
    let opacity = Samples::U8(bytes.chunks(4).map(|texel| texel[3]).collect());
    assert_eq!(in_planes(4).with_extra(2).read().unwrap(), truth.with_opacity(opacity).unwrap());
}

#[test]
fn a_fourth_channel_of_no_meaning_is_named_and_left_out() {
    let job = Job::default();
    let file = TiffFile::new(4, 1, 8, (0..24).collect()).with_extra(0);
    let raster = decode_raster(&file.bytes(), &job).unwrap();
    let expected = (0..24u8).filter(|v| v % 4 < 3).collect();
    assert_eq!(raster, Raster::new(SIZE, 3, Samples::U8(expected)).unwrap());
    assert!(job.remarks()[0].contains("not used: 1 of them"), "{:?}", job.remarks());
}

#[test]
fn colours_of_inks_become_rgb_with_a_warning() {
    let inks = [[0, 0, 0, 0], [255, 0, 0, 0], [0, 0, 0, 255]].concat().repeat(2);
    let file = TiffFile { photometric: 5, ..TiffFile::new(4, 1, 8, inks) };
    let job = Job::default();
    let read = decode_raster(&file.bytes(), &job).unwrap();
    let colours = [[255, 255, 255], [0, 255, 255], [0, 0, 0]].concat().repeat(2);
    assert_eq!(read, Raster::new(SIZE, 3, Samples::U8(colours)).unwrap());
    assert!(job.remarks().concat().contains("(CMYK)"), "{:?}", job.remarks());
}

#[test]
fn greys_of_few_bits_are_spread() {
    // Rows of three samples of 4 bits, padded to whole bytes.
    let file = TiffFile::new(1, 1, 4, vec![0x0f, 0x10, 0x84, 0xf0]);
    assert_eq!(file.read().unwrap().samples(), &Samples::U8(vec![0, 255, 17, 136, 68, 255]));
    let inverse = TiffFile { photometric: 0, ..TiffFile::new(1, 1, 1, vec![0b1010_0000, 0b0100_0000]) };
    assert_eq!(inverse.read().unwrap().samples(), &Samples::U8(vec![0, 255, 0, 255, 0, 255]));
}

#[test]
fn what_is_not_finite_in_a_tiff_is_found() {
    let mut values = GREYS;
    values[4] = f32::NAN;
    let error = TiffFile::new(1, 3, 32, floats(&values)).read().unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Invalid);
    assert!(error.message().contains("'Y' is NaN at texel (1, 1)"), "{error}");
}

#[test]
fn what_is_not_read_is_named_in_the_users_terms() {
    let rgb = |photometric: u16| TiffFile { photometric, ..TiffFile::new(3, 1, 8, (0..18).collect()) };
    let palette = TiffFile { photometric: 3, ..TiffFile::new(1, 1, 8, (0..6).collect()) };
    for (file, word) in [
        (palette, "palettes"),
        (rgb(6), "YCbCr"),
        (TiffFile::new(1, 2, 8, (0..6).collect()), "signed integers"),
        (rgb(8), "stored in this way"),
    ] {
        let error = file.read().unwrap_err();
        assert_eq!(error.kind(), ErrorKind::Unsupported, "{word}: {error}");
        assert!(error.message().contains(word), "{word}: {error}");
    }
}

#[test]
fn a_tiff_header_that_claims_gigabytes_is_refused() {
    let mut bytes = TiffFile::new(3, 1, 8, (0..18).collect()).bytes();
    let generous = Job::new(Limits { max_bytes: 1 << 40, max_side: 1 << 17 });
    // The values of the entries of width, height and rows in a strip.
    for at in [0, 12, 84] {
        bytes[8 + 18 + 2 + 8 + at..][..4].copy_from_slice(&60_000u32.to_le_bytes());
    }
    let error = decode_raster(&bytes, &generous).unwrap_err();
    assert!(error.message().contains("cannot hold so many"), "{error}");
}
