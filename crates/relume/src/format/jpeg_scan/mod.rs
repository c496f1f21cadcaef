//! Whether the entropy-coded data of a JPEG file is complete: every block of every scan is there, bit by bit.
//!
//! Decoders fill what is missing with grey and say nothing, so that a file cut short and closed with an end marker looks
//! whole to them. Here the codes are followed without their values (ITU-T T.81, annexes F and G): Huffman-coded files,
//! sequential and progressive, with restart intervals and with scans of one or several components. Files coded
//! arithmetically or without loss are left to the decoder, which refuses them.

mod bits;
mod block_codes;
mod huffman;
mod progressive;
mod sequential;

use bits::ScanBits;
use huffman::HuffmanTable;

use crate::error::{Error, Result};

/// A component of the frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct ScanComponent {
    id: u8,
    /// Blocks of a unit across and down.
    across: usize,
    down: usize,
    /// Blocks in rows of whole units.
    stride: usize,
    /// Blocks that hold samples of the picture, across and down.
    used: (usize, usize),
    /// The first block among those of all components.
    first: usize,
}

/// The tables and the frame in force.
#[derive(Debug, Default)]
pub(super) struct ScanCheck {
    dc: [Option<HuffmanTable>; 4],
    ac: [Option<HuffmanTable>; 4],
    restart: usize,
    components: Vec<ScanComponent>,
    /// Units across and down.
    units: (usize, usize),
    is_progressive: bool,
    /// Of progressive files: for each block which coefficients are not zero.
    filled: Vec<u64>,
}

/// A number that no block has.
const RESTART: usize = usize::MAX;

/// The parameters of a scan.
struct ScanHead {
    /// Index of the component, of its DC and of its AC table.
    parts: Vec<(usize, usize, usize)>,
    first: u8,
    last: u8,
    is_refinement: bool,
}

impl ScanCheck {
    /// Takes a segment of tables or a frame; whether scans can be followed is known by [`ScanCheck::is_ready`].
    pub(super) fn segment(&mut self, marker: u8, data: &[u8]) {
        match marker {
            0xc4 => self.tables(data),
            0xdd => self.restart = data.first_chunk().map_or(0, |n| usize::from(u16::from_be_bytes(*n))),
            0xc0..=0xc2 => self.frame(marker, data),
            // Arithmetic coding, and frames without loss.
            0xc3 | 0xc5..=0xc7 | 0xc9..=0xcb | 0xcd..=0xcf => self.components.clear(),
            _ => {}
        }
    }

    /// Whether a frame that can be followed is known.
    pub(super) fn is_ready(&self) -> bool {
        !self.components.is_empty()
    }

    fn tables(&mut self, mut data: &[u8]) {
        while let Some((table, class, number, used)) = HuffmanTable::parse(data) {
            let list = if class == 0 { &mut self.dc } else { &mut self.ac };
            list[number] = Some(table);
            data = &data[used..];
        }
    }

    fn frame(&mut self, marker: u8, data: &[u8]) {
        self.components.clear();
        let [8, h1, h0, w1, w0, count, rest @ ..] = data else { return };
        let (height, width) =
            (usize::from(*h1) << 8 | usize::from(*h0), usize::from(*w1) << 8 | usize::from(*w0));
        let parts: Vec<&[u8]> = rest.chunks_exact(3).take(usize::from(*count)).collect();
        let sides = |part: &[u8]| (usize::from(part[1] >> 4), usize::from(part[1] & 15));
        let sound = |part: &&[u8]| (1..=4).contains(&sides(part).0) && (1..=4).contains(&sides(part).1);
        if height == 0 || width == 0 || parts.len() != usize::from(*count) || !parts.iter().all(sound) {
            return;
        }
        let most_across = parts.iter().map(|part| sides(part).0).max().unwrap_or(1);
        let most_down = parts.iter().map(|part| sides(part).1).max().unwrap_or(1);
        self.units = (width.div_ceil(8 * most_across), height.div_ceil(8 * most_down));
        let mut first = 0;
        for part in parts {
            let (across, down) = sides(part);
            let stride = self.units.0 * across;
            let used = ((width * across).div_ceil(8 * most_across), (height * down).div_ceil(8 * most_down));
            self.components.push(ScanComponent { id: part[0], across, down, stride, used, first });
            first += stride * self.units.1 * down;
        }
        self.is_progressive = marker == 0xc2;
        self.filled = if self.is_progressive { vec![0; first] } else { Vec::new() };
    }

    fn head(&self, data: &[u8]) -> Option<ScanHead> {
        let (count, rest) = data.split_first()?;
        let count = usize::from(*count);
        let parts = rest.get(..2 * count)?.chunks_exact(2).map(|part| {
            let component = self.components.iter().position(|component| component.id == part[0])?;
            Some((component, usize::from(part[1] >> 4 & 3), usize::from(part[1] & 3)))
        });
        let parts: Vec<_> = parts.collect::<Option<_>>()?;
        let [first, last, approximation] = *rest.get(2 * count..2 * count + 3)? else { return None };
        let sound = !parts.is_empty() && parts.len() <= 4 && first <= last && last < 64;
        sound.then_some(ScanHead { parts, first, last, is_refinement: approximation >> 4 != 0 })
    }

    /// Follows a scan whose header is `head`, from the byte `at` on; a place before the next marker, behind the data followed.
    ///
    /// # Errors
    /// Data that ends before the last block, or that no table has a code for, with the place.
    pub(super) fn scan(&mut self, head: &[u8], bytes: &[u8], at: usize) -> Result<usize> {
        let Some(head) = self.head(head) else {
            return Err(Error::invalid(format!(
                "the JPEG scan before byte {at} has a damaged header: export the file again"
            )));
        };
        let mut bits = ScanBits::new(bytes, at);
        let done = match self.is_progressive {
            true => self.progressive(&head, &mut bits),
            false => self.sequential(&head, &mut bits),
        };
        done.map(|()| bits.position()).ok_or_else(|| {
            Error::invalid(format!(
                "the JPEG scan from byte {at} on ends at byte {} before its last block: the file is damaged or truncated",
                bits.position()
            ))
        })
    }

    /// Calls `block` for every block of a scan in order, with the place of its component in the scan and its number; between
    /// restart intervals with [`RESTART`] for the number.
    fn blocks(
        &self,
        head: &ScanHead,
        bits: &mut ScanBits<'_>,
        mut block: impl FnMut(&mut ScanBits<'_>, usize, usize) -> Option<()>,
    ) -> Option<()> {
        let alone = (head.parts.len() == 1).then(|| self.components[head.parts[0].0]);
        let (across, down) = alone.map_or(self.units, |component| component.used);
        for unit in 0..across * down {
            if self.restart > 0 && unit > 0 && unit % self.restart == 0 {
                bits.restart()?;
                block(bits, 0, RESTART)?;
            }
            let (x, y) = (unit % across, unit / across);
            if let Some(component) = alone {
                block(bits, 0, component.first + y * component.stride + x)?;
                continue;
            }
            for (part, &(index, ..)) in head.parts.iter().enumerate() {
                let component = self.components[index];
                for (v, h) in (0..component.down).flat_map(|v| (0..component.across).map(move |h| (v, h))) {
                    let row = y * component.down + v;
                    block(bits, part, component.first + row * component.stride + x * component.across + h)?;
                }
            }
        }
        Some(())
    }
}

#[cfg(test)]
mod tests {
    use crate::error::ErrorKind;
    use crate::format::complete::check_jpeg;
    use crate::numeric::random::{Purpose, Stream};

    fn jpeg(width: u32, height: u32, channels: usize) -> Vec<u8> {
        let mut random = Stream::new(3, Purpose::Sample, [0]);
        let samples: Vec<u8> = (0..(width * height) as usize * channels)
            .map(|i| (i / channels * 3 % 200) as u8 + random.below(40) as u8)
            .collect();
        let color = if channels == 1 { image::ExtendedColorType::L8 } else { image::ExtendedColorType::Rgb8 };
        let mut out = Vec::new();
        image::codecs::jpeg::JpegEncoder::new_with_quality(&mut out, 85)
            .encode(&samples, width, height, color)
            .unwrap();
        out
    }

    #[test]
    fn jpegs_cut_short_and_closed_with_an_end_marker_are_errors() {
        for (width, height, channels) in [(40, 24, 1), (33, 50, 3), (64, 64, 3)] {
            let whole = jpeg(width, height, channels);
            assert!(check_jpeg(&whole).is_ok());
            let scan = whole.windows(2).position(|w| w == [0xff, 0xda]).unwrap();
            for length in (scan + 20..whole.len() - 4).step_by(7) {
                let mut cut = whole[..length].to_vec();
                // A marker must not begin with the last byte.
                if cut.ends_with(&[0xff]) {
                    cut.pop();
                }
                cut.extend([0xff, 0xd9]);
                let error = check_jpeg(&cut).map(drop).unwrap_err();
                assert_eq!(error.kind(), ErrorKind::Invalid);
                assert!(error.message().contains("truncated"), "{error}");
            }
        }
    }
}
