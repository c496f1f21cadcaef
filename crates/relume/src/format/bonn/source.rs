//! The bytes of a `.btf` file: all in memory, or read from the file where they are needed, because files of whole
//! images can be larger than memory. Positions are 64-bit.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};

use half::f16;

use super::BtfScalar;
use crate::error::{Error, Result};
use crate::job::Job;
use crate::memory;

/// Where the bytes are.
#[derive(Debug)]
enum BtfBytes {
    Memory(Arc<Vec<u8>>),
    Disk(Mutex<File>),
}

/// The bytes of a file, read at any position from any thread.
#[derive(Debug)]
pub(super) struct BtfSource {
    place: BtfBytes,
    length: u64,
}

/// No bytes.
impl Default for BtfSource {
    fn default() -> Self {
        Self::of_bytes(Arc::default())
    }
}

impl BtfSource {
    pub(super) fn of_bytes(bytes: Arc<Vec<u8>>) -> Self {
        Self { length: bytes.len() as u64, place: BtfBytes::Memory(bytes) }
    }

    pub(super) fn of_file(path: &Path) -> Result<Self> {
        let io = |source: std::io::Error| Error::io("cannot read the file", &source);
        let file = File::open(path).map_err(io)?;
        let length = file.metadata().map_err(io)?.len();
        Ok(Self { place: BtfBytes::Disk(Mutex::new(file)), length })
    }

    pub(super) fn is_in_memory(&self) -> bool {
        matches!(self.place, BtfBytes::Memory(_))
    }

    pub(super) fn length(&self) -> u64 {
        self.length
    }

    /// Fills `out` from byte `at` on, which the caller knows to lie inside.
    pub(super) fn read(&self, at: u64, out: &mut [u8]) -> Result<()> {
        let shorter =
            || Error::invalid(format!("the BTF file became shorter than {at} bytes while it was read"));
        match &self.place {
            BtfBytes::Memory(bytes) => {
                let start = usize::try_from(at).map_err(|_| shorter())?;
                let part = bytes.get(start..).and_then(|rest| rest.get(..out.len())).ok_or_else(shorter)?;
                out.copy_from_slice(part);
                Ok(())
            }
            BtfBytes::Disk(file) => {
                let mut file = file.lock().unwrap_or_else(PoisonError::into_inner);
                let io = |source: std::io::Error| Error::io("cannot read the file", &source);
                file.seek(SeekFrom::Start(at)).map_err(io)?;
                file.read_exact(out).map_err(io)
            }
        }
    }
}

/// Reads a file from its beginning to its end.
pub(super) struct BtfCursor<'a> {
    source: &'a BtfSource,
    job: &'a Job,
    at: u64,
}

impl<'a> BtfCursor<'a> {
    pub(super) fn new(source: &'a BtfSource, job: &'a Job, at: u64) -> Self {
        Self { source, job, at }
    }

    pub(super) fn at(&self) -> u64 {
        self.at
    }

    pub(super) fn job(&self) -> &'a Job {
        self.job
    }

    fn left(&self) -> u64 {
        self.source.length().saturating_sub(self.at)
    }

    /// Refuses `bytes` more, for `what`, when the file does not have them.
    pub(super) fn expect(&self, what: &str, bytes: u64) -> Result<()> {
        if bytes <= self.left() {
            return Ok(());
        }
        Err(Error::invalid(format!(
            "the BTF file needs {bytes} bytes for {what} from byte {} on, and {} follow: it is damaged or truncated",
            self.at,
            self.left()
        )))
    }

    pub(super) fn skip(&mut self, what: &str, bytes: u64) -> Result<()> {
        self.expect(what, bytes)?;
        self.at += bytes;
        Ok(())
    }

    /// Steps back over bytes that have been read.
    pub(super) fn rewind(&mut self, bytes: usize) {
        self.at -= bytes as u64;
    }

    fn array<const N: usize>(&mut self, what: &str) -> Result<[u8; N]> {
        self.expect(what, N as u64)?;
        let mut bytes = [0; N];
        self.source.read(self.at, &mut bytes)?;
        self.at += N as u64;
        Ok(bytes)
    }

    pub(super) fn u8(&mut self, what: &str) -> Result<u8> {
        self.array::<1>(what).map(|[byte]| byte)
    }

    pub(super) fn u32(&mut self, what: &str) -> Result<u32> {
        self.array(what).map(u32::from_le_bytes)
    }

    pub(super) fn f32(&mut self, what: &str) -> Result<f32> {
        self.array(what).map(f32::from_le_bytes)
    }

    /// A text of `length` bytes without the zeros that pad it.
    pub(super) fn text(&mut self, what: &str, length: u64) -> Result<String> {
        let bytes = self.bytes(what, length)?;
        Ok(String::from_utf8_lossy(&bytes).trim_end_matches('\0').to_owned())
    }

    pub(super) fn bytes(&mut self, what: &str, length: u64) -> Result<Vec<u8>> {
        self.expect(what, length)?;
        self.job.check_bytes(what, length)?;
        let mut bytes = memory::zeros(what, length as usize)?;
        self.source.read(self.at, &mut bytes)?;
        self.at += length;
        Ok(bytes)
    }

    /// `count` numbers as `f32`, all finite; the caller holds their memory.
    pub(super) fn numbers(&mut self, what: &str, count: u64, scalar: BtfScalar) -> Result<Vec<f32>> {
        let bytes = count.saturating_mul(scalar.bytes());
        self.expect(what, bytes)?;
        let mut numbers = memory::with_capacity(what, count as usize)?;
        let mut buffer = [0; BUFFER];
        let (start, mut left) = (self.at, bytes);
        while left > 0 {
            self.job.proceed()?;
            let part = &mut buffer[..left.min(BUFFER as u64) as usize];
            self.source.read(self.at, part)?;
            scalar.decode_into(part, &mut numbers);
            self.at += part.len() as u64;
            left -= part.len() as u64;
        }
        match numbers.iter().position(|number: &f32| !number.is_finite()) {
            None => Ok(numbers),
            Some(i) => Err(Error::invalid(format!(
                "number {i} of {what} in the BTF file, at byte {}, is not finite: the file is damaged",
                start + i as u64 * scalar.bytes()
            ))),
        }
    }
}

/// Bytes read from the file at a time: a multiple of the size of every scalar.
const BUFFER: usize = 1 << 16;

impl BtfScalar {
    /// The scalar of a size in bytes.
    pub(super) fn of_size(size: u8, what: &str) -> Result<Self> {
        match size {
            2 => Ok(Self::Half),
            4 => Ok(Self::Float),
            8 => Ok(Self::Double),
            _ => Err(Error::invalid(format!(
                "{what} in the BTF file has numbers of {size} bytes: expected 2, 4 or 8"
            ))),
        }
    }

    /// The bits of a number.
    pub fn bits(self) -> u64 {
        8 * self.bytes()
    }

    /// The bytes of a number.
    pub fn bytes(self) -> u64 {
        match self {
            Self::Half => 2,
            Self::Float => 4,
            Self::Double => 8,
        }
    }

    fn decode_into(self, bytes: &[u8], out: &mut Vec<f32>) {
        match self {
            Self::Half => out.extend(bytes.chunks_exact(2).map(|b| half_at(b).to_f32())),
            Self::Float => {
                out.extend(bytes.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])));
            }
            Self::Double => out.extend(bytes.chunks_exact(8).map(|b| {
                let mut eight = [0; 8];
                eight.copy_from_slice(b);
                f64::from_le_bytes(eight) as f32
            })),
        }
    }

    /// Adds the bytes of numbers; `None` where the scalar cannot hold one.
    pub(super) fn encode_into(self, numbers: impl Iterator<Item = f32>, out: &mut Vec<u8>) -> Option<()> {
        for number in numbers {
            let stored = f16::from_f32(number);
            match self {
                Self::Half if !stored.is_finite() => return None,
                _ if !number.is_finite() => return None,
                Self::Half => out.extend(stored.to_le_bytes()),
                Self::Float => out.extend(number.to_le_bytes()),
                Self::Double => out.extend(f64::from(number).to_le_bytes()),
            }
        }
        Some(())
    }
}

/// A little-endian half float.
pub(super) fn half_at(bytes: &[u8]) -> f16 {
    f16::from_le_bytes([bytes[0], bytes[1]])
}
