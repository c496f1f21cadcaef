//! Files written by hand, and round trips.

use super::*;
use crate::error::ErrorKind;
use crate::limits::Limits;
use crate::numeric::random::{Purpose, Stream};
use crate::planes::Planes;
use crate::size::Size;
use crate::space::Space;

const HEAD: &str = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n";

fn read(bytes: &[u8]) -> Result<Raster> {
    decode(bytes, &Job::default())
}

fn samples(bytes: &[u8]) -> Vec<f32> {
    match read(bytes).unwrap().samples() {
        Samples::F32(samples) => samples.clone(),
        other => panic!("{other:?}"),
    }
}

/// A file of the texels of a resolution line.
fn file(resolution: &str, data: &[u8]) -> Vec<u8> {
    [HEAD.as_bytes(), resolution.as_bytes(), b"\n", data].concat()
}

#[test]
fn values_are_mantissas_times_powers_of_two() {
    let data = [[128, 64, 0, 129], [255, 1, 3, 128], [200, 100, 50, 0], [1, 0, 2, 136]].concat();
    let expected = [1.0, 0.5, 0.0, 255.0 / 256.0, 1.0 / 256.0, 3.0 / 256.0, 0.0, 0.0, 0.0, 1.0, 0.0, 2.0];
    assert_eq!(samples(&file("-Y 1 +X 4", &data)), expected);
}

/// The eight orders of a picture of 3 x 2 texels whose texel (x, y) has the red mantissa 10 + x + 3 y.
#[test]
fn all_eight_orders_give_the_same_picture() {
    let texel = |x: usize, y: usize| [10 + (x + 3 * y) as u8, 0, 0, 136];
    let (right, left) = ([0, 1, 2], [2, 1, 0]);
    let (down, up) = ([0, 1], [1, 0]);
    let expected = samples(&file("-Y 2 +X 3", &down.map(|y| right.map(|x| texel(x, y)).concat()).concat()));
    assert_eq!(expected.iter().step_by(3).copied().collect::<Vec<_>>(), [10.0, 11.0, 12.0, 13.0, 14.0, 15.0]);
    for (y_sign, rows) in [("-", down), ("+", up)] {
        for (x_sign, columns) in [("+", right), ("-", left)] {
            let by_rows = rows.map(|y| columns.map(|x| texel(x, y)).concat()).concat();
            let by_columns = columns.map(|x| rows.map(|y| texel(x, y)).concat()).concat();
            assert_eq!(samples(&file(&format!("{y_sign}Y 2 {x_sign}X 3"), &by_rows)), expected);
            assert_eq!(samples(&file(&format!("{x_sign}X 3 {y_sign}Y 2"), &by_columns)), expected);
        }
    }
}

#[test]
fn older_runs_repeat_texels_and_count_in_bytes() {
    // One texel and 2 + 256 repetitions of it, then another.
    let data = [[9, 8, 7, 136], [1, 1, 1, 2], [1, 1, 1, 1], [5, 5, 5, 136]].concat();
    let found = samples(&file("-Y 1 +X 260", &data));
    assert!(found.chunks(3).take(259).all(|texel| texel == [9.0, 8.0, 7.0]));
    assert_eq!(found[777..], [5.0; 3]);
    // Another texel ends the counting.
    let data = [[9, 8, 7, 136], [1, 1, 1, 2], [4, 4, 4, 136], [1, 1, 1, 1]].concat();
    assert_eq!(samples(&file("-Y 1 +X 5", &data))[9..], [4.0; 6]);
}

#[test]
fn newer_runs_are_those_of_each_component() {
    let data = [2, 2, 0, 9, 128 + 9, 3, 9, 1, 2, 3, 4, 5, 6, 7, 8, 9, 128 + 5, 0, 128 + 4, 7, 128 + 9, 136];
    let found = samples(&file("-Y 1 +X 9", &data));
    for (i, texel) in found.chunks(3).enumerate() {
        assert_eq!(texel, [3.0, i as f32 + 1.0, if i < 5 { 0.0 } else { 7.0 }]);
    }
}

#[test]
fn exposures_are_divided_out_and_said() {
    let head = "#?RGBE\n# a comment\nEXPOSURE=2\nFORMAT=32-bit_rle_rgbe\r\nEXPOSURE= 4\nCOLORCORR=1 2 4\n\n-Y 1 +X 1\n";
    let job = Job::default();
    let raster = decode(&[head.as_bytes(), &[64, 64, 64, 136]].concat(), &job).unwrap();
    assert_eq!(raster.samples(), &Samples::F32(vec![8.0, 4.0, 2.0]));
    assert!(job.remarks()[0].contains("exposure 8, 16, 32"), "{:?}", job.remarks());
    let said = |lines: &str, data: &[u8]| {
        let job = Job::default();
        decode(&[b"#?RADIANCE\n", lines.as_bytes(), b"\n-Y 1 +X 1\n", data].concat(), &job).unwrap();
        job.remarks()
    };
    assert!(said("", &[0; 4])[0].contains("FORMAT"));
    let format = "FORMAT=32-bit_rle_rgbe\n";
    assert!(said(format, &[0; 4]).is_empty());
    assert!(said(format, &[0; 7])[0].contains("3 bytes after"));
    assert!(said(&format!("{format}PRIMARIES=.64 .33 .29 .6 .15 .06 .3333 .3333\n"), &[0; 4]).is_empty());
    assert!(said(&format!("{format}PRIMARIES=.7 .3 .2 .7 .1 .1 .3 .3\n"), &[0; 4])[0].contains("PRIMARIES"));
}

#[test]
fn broken_files_are_refused_in_a_sentence() {
    let refused = |bytes: &[u8]| read(bytes).unwrap_err().to_string();
    let xyz = "#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 1\n\0\0\0\0";
    assert!(refused(xyz.as_bytes()).contains("CIE XYZ"));
    assert!(refused(b"#?RADIANCE\nFORMAT=other\n\n-Y 1 +X 1\n\0\0\0\0").contains("'other'"));
    for exposure in ["0", "-1", "nan", "inf", "", "1 2"] {
        let head = format!("#?RADIANCE\nEXPOSURE={exposure}\n\n-Y 1 +X 1\n\0\0\0\0");
        assert!(refused(head.as_bytes()).contains("EXPOSURE"), "{exposure}");
    }
    for line in ["-Y 1", "-Y 1 -Y 1", "+X 1 -X 1", "-Y -1 +X 1", "Y 1 X 1", "-Y 1 +X 1 1", "-Y 1e3 +X 1"] {
        assert!(refused(&file(line, &[0; 16])).contains("resolution line"), "{line}");
    }
    assert!(refused(&file("-Y 0 +X 1", &[0; 16])).contains("at least 1"));
    // A run without a texel before it, one that is too long, other lengths than the scanline's, a count of zero.
    let runs: [&[u8]; 5] = [
        &[1, 1, 1, 3, 0, 0, 0, 0],
        &[9, 9, 9, 9, 1, 1, 1, 9],
        &[2, 2, 0, 9, 137, 0, 137, 0, 137, 0, 137, 0],
        &[2, 2, 0, 8, 137, 0, 136, 0, 136, 0, 136, 0],
        &[2, 2, 0, 8, 0, 0, 136, 0, 136, 0, 136, 0],
    ];
    for data in runs {
        assert!(refused(&file("-Y 1 +X 8", data)).contains("scanline 0"), "{data:?}");
    }
}

#[test]
fn a_head_that_claims_gigabytes_is_refused_before_memory_is_taken() {
    let bomb = file("-Y 100000 +X 100000", &[0; 100]);
    assert_eq!(read(&bomb).unwrap_err().kind(), ErrorKind::Limit);
    let generous = Job::new(Limits { max_bytes: 1 << 40, ..Limits::default() });
    let error = decode(&bomb, &generous).unwrap_err();
    assert!(error.message().contains("cannot hold so many"), "{error}");
}

#[test]
fn pictures_come_back_to_half_a_unit_of_the_largest_component() {
    let mut stream = Stream::new(3, Purpose::Sample, [0]);
    for (size, channels) in [(Size::new(7, 3), 3), (Size::new(8, 2), 1), (Size::new(300, 2), 3)] {
        // Of a large range, with runs.
        let mut value = |i: usize| {
            if (i / 20).is_multiple_of(2) { 0.25 } else { (20.0 * stream.unit() - 10.0).exp2() as f32 }
        };
        let data = (0..channels * size.texels()).map(&mut value).collect();
        let picture =
            Picture { planes: Planes::from_vec(size, channels, data).unwrap(), space: Space::Linear };
        let bytes = encode(&picture);
        let back = read(&bytes).unwrap().to_picture(Space::Linear);
        for texel in 0..size.texels() {
            let color = |p: &Picture, c: usize| p.planes.plane(c.min(p.planes.count() - 1))[texel];
            let largest = (0..3).map(|c| color(&picture, c)).fold(0.0, f32::max);
            for c in 0..3 {
                let error = (color(&picture, c) - color(&back, c)).abs();
                assert!(error <= largest / 255.0, "{} became {}", color(&picture, c), color(&back, c));
            }
        }
        // What was read is written without any change.
        assert_eq!(encode(&back), bytes);
    }
}

#[test]
fn colours_beyond_the_range_of_the_format_are_its_ends() {
    assert_eq!(rgbe([-1.0, f32::NAN, 0.0]), [0; 4]);
    assert_eq!(rgbe([f32::INFINITY, 0.0, 1.0]), [255, 0, 0, 255]);
    assert_eq!(rgbe([1e-42, 0.0, 0.0]), [0; 4]);
    assert_eq!(rgbe([1.0, 0.5, 0.25]), [128, 64, 32, 129]);
    // Rounding up to 256 takes the next exponent.
    assert_eq!(rgbe([0.9999, 0.0, 0.0]), [128, 0, 0, 129]);
    for value in [0.18f32, 1.0, 3.7e9, 2e-20] {
        let [r, g, b, _] = rgbe([value; 3]);
        assert!(r >= 128 && r == g && g == b);
    }
}
