//! Shared by several modules of tests.

use std::path::PathBuf;

use relume::field::{Basis, PlaneLayout};
use relume::numeric::random::{Purpose, Stream};
use relume::{Job, Limits, Planes, ReflectanceField, Size, Space};

pub fn job() -> Job {
    Job::new(Limits { max_bytes: 1 << 26, max_side: 1 << 15 })
}

/// A file of the test data, or `None`, with a message, where it is missing.
pub fn data(relative: &str) -> Option<PathBuf> {
    let root = std::env::var_os("RELUME_DATA").map_or_else(
        || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data"),
        PathBuf::from,
    );
    let path = root.join(relative);
    if path.exists() {
        return Some(path);
    }
    println!("SKIPPED: {} is not there; RELUME_DATA names the folder of test data", path.display());
    None
}

/// A field of random coefficients: colours between 0 and 1, functions between -1 and 1.
pub fn random_field(
    basis: Basis,
    color: PlaneLayout,
    space: Space,
    size: Size,
    seed: u64,
) -> ReflectanceField {
    let mut random = Stream::new(seed, Purpose::Sample, [0]);
    let count = color.planes(basis.len());
    let first_color = if color == PlaneLayout::LRGB { basis.len() } else { count };
    let mut planes = Planes::zeros(size, count);
    for (k, plane) in planes.iter_mut().enumerate() {
        let is_plain = k >= first_color || basis == Basis::Constant;
        plane.iter_mut().for_each(|v| {
            let unit = random.unit() as f32;
            *v = if is_plain { unit } else { 2.0 * unit - 1.0 };
        });
    }
    ReflectanceField::new(basis, color, space, planes).unwrap()
}
