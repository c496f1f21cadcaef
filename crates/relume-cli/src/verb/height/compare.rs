//! Comparison with a known shape.

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use relume::format::NormalY;
use relume::metric::{AngleError, HeightError, angle_error, height_error};
use relume::{Error, Planes, Result, Size};

use crate::context::Context;
use crate::input;

/// Files of the truth.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Comparison")]
pub struct Truth {
    /// A known height map to compare with
    #[arg(long, value_name = "FILE")]
    truth_height: Option<PathBuf>,
    /// Texels from 0 to 1 of a known height map without a recorded range
    #[arg(long, value_name = "TEXELS", requires = "truth_height", default_value_t = 1.0)]
    truth_scale: f64,
    /// A known normal map to compare with
    #[arg(long, value_name = "FILE")]
    truth_normals: Option<PathBuf>,
}

/// The known shape, as far as it is known.
#[derive(Debug)]
pub struct KnownShape {
    height: Option<(PathBuf, Planes)>,
    normals: Option<(PathBuf, Planes)>,
}

/// The error of the estimated shape.
#[derive(Debug)]
pub struct Compared {
    pub height: Option<HeightError>,
    pub normals: Option<AngleError>,
}

impl Truth {
    /// The given files.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        self.truth_height.iter().chain(&self.truth_normals).map(PathBuf::as_path)
    }

    /// Reads the given files, before the work.
    pub fn read(&self, y: Option<NormalY>, context: &Context) -> Result<KnownShape> {
        let job = &context.job;
        let height = self.truth_height.as_ref().map(|path| {
            let truth = input::height(path, job)?.texels(self.truth_scale);
            Ok((path.clone(), truth.held(job, "the known heights").map_err(|e| e.at(path))?))
        });
        let normals = self.truth_normals.as_ref().map(|path| {
            let truth = input::normals(path, y, job)?.normals;
            Ok((path.clone(), truth.held(job, "the known normals").map_err(|e| e.at(path))?))
        });
        Ok(KnownShape { height: height.transpose()?, normals: normals.transpose()? })
    }
}

impl KnownShape {
    /// Refuses files of another size than the surface that is estimated.
    pub fn check(&self, size: Size) -> Result<()> {
        match self.height.iter().chain(&self.normals).find(|(_, truth)| truth.size() != size) {
            Some((path, truth)) => Err(Error::usage(format!(
                "has {} texels and the surface {size}: they must have the same size",
                truth.size()
            ))
            .at(path)),
            None => Ok(()),
        }
    }

    /// Compares an estimate with it.
    pub fn compare(&self, height: &Planes, normals: &Planes, mask: Option<&[bool]>) -> Result<Compared> {
        let of_height = |(path, truth): &(PathBuf, Planes)| {
            height_error(&within(height, mask), &within(truth, mask)).map_err(|e| e.at(path))
        };
        let of_normals = |(path, truth): &(PathBuf, Planes)| {
            angle_error(&within(normals, mask), &within(truth, mask)).map_err(|e| e.at(path))
        };
        Ok(Compared {
            height: self.height.as_ref().map(of_height).transpose()?,
            normals: self.normals.as_ref().map(of_normals).transpose()?,
        })
    }
}

/// The texels of a mask, in one row.
fn within<'a>(planes: &'a Planes, mask: Option<&[bool]>) -> Cow<'a, Planes> {
    let Some(mask) = mask else { return Cow::Borrowed(planes) };
    let inside = |plane: &[f32]| -> Vec<f32> {
        plane.iter().zip(mask).filter(|(_, inside)| **inside).map(|(value, _)| *value).collect()
    };
    let values: Vec<f32> = planes.iter().flat_map(inside).collect();
    let size = Size::new(values.len() / planes.count(), 1);
    Cow::Owned(Planes::from_vec(size, planes.count(), values).expect("as many values of each plane"))
}

impl Compared {
    /// For people.
    pub fn lines(&self) -> Vec<String> {
        let height = self.height.map(|e| {
            format!(
                "height: RMSE {:.3} texels (a level surface has {:.3}), correlation {:.4}",
                e.rmse, e.true_deviation, e.correlation
            )
        });
        let normals = self.normals.map(|e| {
            format!(
                "normals: mean error {:.2} degrees, median {:.2}, 95 % below {:.2}",
                e.mean_deg, e.median_deg, e.p95_deg
            )
        });
        height.into_iter().chain(normals).collect()
    }
}
