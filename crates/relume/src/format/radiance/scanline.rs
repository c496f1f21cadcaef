//! Scanlines of a Radiance picture: flat, with the older runs of whole texels, or with the newer runs of bytes of
//! each component.

use crate::error::{Error, Result};

/// The lengths of scanlines that can have runs of bytes.
const RUNS: std::ops::Range<usize> = 8..1 << 15;
/// The shortest run that is written as one.
const LEAST_RUN: usize = 4;
/// The longest run, and the most single bytes, of one count.
const MOST_RUN: usize = 127;
const MOST_SINGLE: usize = 128;

/// Red, green and blue mantissas and the common exponent of a texel.
pub(super) type Rgbe = [u8; 4];

/// The scanlines of a file, read one after another.
pub(super) struct Scanlines<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Scanlines<'a> {
    /// Those that begin at byte `at`.
    pub fn new(bytes: &'a [u8], at: usize) -> Self {
        Self { bytes, at }
    }

    /// The bytes after those that have been read.
    pub fn left(&self) -> usize {
        self.bytes.len() - self.at
    }

    /// Reads scanline `line` into all of `out`.
    pub fn read(&mut self, line: usize, out: &mut [Rgbe]) -> Result<()> {
        let start = self.at;
        let length = out.len();
        let runs = match self.bytes.get(start..start + 4) {
            Some(&[2, 2, high, low]) if high < 128 && RUNS.contains(&length) => {
                Some(usize::from(high) << 8 | usize::from(low))
            }
            _ => None,
        };
        let read = match runs {
            Some(said) if said == length => {
                self.at += 4;
                self.component_runs(out)
            }
            Some(_) => None,
            None => self.texel_runs(out),
        };
        read.ok_or_else(|| {
            Error::invalid(format!(
                "scanline {line} of the Radiance file, at byte {start}, does not hold its {length} texels: the file is \
                 damaged or truncated"
            ))
        })
    }

    fn take<const N: usize>(&mut self) -> Option<[u8; N]> {
        let taken = self.bytes.get(self.at..self.at + N)?.try_into().ok()?;
        self.at += N;
        Some(taken)
    }

    /// All bytes of a component, then those of the next: a count above 128 repeats one byte, another is followed by
    /// as many bytes.
    fn component_runs(&mut self, out: &mut [Rgbe]) -> Option<()> {
        for component in 0..4 {
            let mut done = 0;
            while done < out.len() {
                let [count] = self.take()?;
                let (length, repeats) = match usize::from(count) {
                    0 => return None,
                    count @ 1..=MOST_SINGLE => (count, false),
                    count => (count - MOST_SINGLE, true),
                };
                let texels = out.get_mut(done..done + length)?;
                if repeats {
                    let [value] = self.take()?;
                    texels.iter_mut().for_each(|texel| texel[component] = value);
                } else {
                    let values = self.bytes.get(self.at..self.at + length)?;
                    self.at += length;
                    texels.iter_mut().zip(values).for_each(|(texel, &value)| texel[component] = value);
                }
                done += length;
            }
        }
        Some(())
    }

    /// Texels of four bytes. The mantissas 1, 1, 1 mark a repetition of the texel before: the last byte is the count,
    /// and in marks that follow one another the next eight bits of it.
    fn texel_runs(&mut self, out: &mut [Rgbe]) -> Option<()> {
        let (mut done, mut shift) = (0, 0);
        while done < out.len() {
            let texel: Rgbe = self.take()?;
            if texel[..3] == [1, 1, 1] {
                let count = usize::from(texel[3]).checked_shl(shift).filter(|_| shift < 32)?;
                let last = *out.get(done.checked_sub(1)?)?;
                out.get_mut(done..done.checked_add(count)?)?.fill(last);
                done += count;
                shift += 8;
            } else {
                out[done] = texel;
                done += 1;
                shift = 0;
            }
        }
        Some(())
    }
}

/// Appends a scanline, with runs of bytes where its length allows them.
pub(super) fn write(line: &[Rgbe], out: &mut Vec<u8>) {
    // The largest mantissa of a texel is at least 128, so none looks like a mark of the older runs.
    if !RUNS.contains(&line.len()) {
        return line.iter().for_each(|texel| out.extend(texel));
    }
    out.extend([2, 2, (line.len() >> 8) as u8, (line.len() & 0xff) as u8]);
    for component in 0..4 {
        let value = |i: usize| line[i][component];
        let run_at = |i: usize| (i..line.len()).take(MOST_RUN).take_while(|&k| value(k) == value(i)).count();
        let mut at = 0;
        while at < line.len() {
            let run = run_at(at);
            if run >= LEAST_RUN {
                out.extend([(MOST_SINGLE + run) as u8, value(at)]);
                at += run;
            } else {
                let most = line.len().min(at + MOST_SINGLE);
                let end = (at..most).find(|&i| run_at(i) >= LEAST_RUN).unwrap_or(most);
                out.push((end - at) as u8);
                out.extend((at..end).map(value));
                at = end;
            }
        }
    }
}
