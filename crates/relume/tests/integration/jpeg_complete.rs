//! JPEG files of another encoder, cut anywhere inside their scans and closed with an end marker: progressive, with
//! fewer samples of chroma, grey, and with restart intervals. (Made with Pillow from a pattern of our own.)

use relume::format::decode_raster;
use relume::{ErrorKind, Size};

use crate::support::job;

/// Where the segments of a file begin and end, and the entropy-coded data between them.
fn scans(file: &[u8]) -> Vec<(usize, usize)> {
    let mut scans = Vec::new();
    let mut at = 2;
    while at + 4 <= file.len() && file[at + 1] != 0xd9 {
        let length = usize::from(u16::from_be_bytes([file[at + 2], file[at + 3]]));
        let is_scan = file[at + 1] == 0xda;
        at += 2 + length;
        if is_scan {
            let start = at;
            while file[at] != 0xff || matches!(file[at + 1], 0 | 0xd0..=0xd7) {
                at += 1;
            }
            scans.push((start, at));
        }
    }
    scans
}

#[test]
fn jpegs_of_every_kind_cut_short_and_closed_are_errors() {
    let files: [(&str, &[u8], usize); 3] = [
        ("progressive", include_bytes!("../data/progressive.jpg"), 10),
        ("grey_progressive", include_bytes!("../data/grey_progressive.jpg"), 6),
        ("restarts", include_bytes!("../data/restarts.jpg"), 1),
    ];
    for (name, file, count) in files {
        assert_eq!(decode_raster(file, &job()).unwrap().size(), Size::new(50, 37), "{name}");
        let scans = scans(file);
        assert_eq!(scans.len(), count, "{name}");
        let (mut refused, mut tried) = (0, 0);
        for (start, end) in scans {
            // The last bytes of a scan may hold only padding.
            for cut in (start..end.saturating_sub(2)).step_by(3) {
                let mut bytes = file[..cut].to_vec();
                while bytes.last() == Some(&0xff) {
                    bytes.pop();
                }
                bytes.extend([0xff, 0xd9]);
                tried += 1;
                if let Err(error) = decode_raster(&bytes, &job()) {
                    assert_eq!(error.kind(), ErrorKind::Invalid, "{name}: {error}");
                    refused += 1;
                }
            }
        }
        assert!(tried > 50 && refused == tried, "{name}: {refused} of {tried} refused");
    }
}
