//! Environments on the command line: light from all around, from a map or the built-in sky.

use std::path::{Path, PathBuf};

use relume::render::{Environment, EnvironmentLight, EnvironmentMethod};
use relume::{Job, Result, Space};
use serde_json::{Value, json};

use crate::{input, paths};

/// The name of the built-in environment.
const SKY: &str = "sky";
/// The samples of a point unless others are asked for.
const SAMPLES: usize = 256;

/// How the map of an environment is used.
#[derive(Debug, clap::Args)]
#[group(skip)]
#[command(next_help_heading = "Environment")]
pub struct Adjustment {
    /// Turn the environment to the right about the vertical axis
    #[arg(long, value_name = "DEG", allow_hyphen_values = true, default_value_t = 0.0, requires = "env")]
    env_rotate: f64,
    /// Multiply its light, 0 to 1,000,000; 1 shows a white matt surface as white where the map is 1 all around
    #[arg(long, value_name = "S", default_value_t = 1.0, requires = "env")]
    env_strength: f64,
}

/// The environment of a rendered scene.
#[derive(Debug, clap::Args)]
#[group(skip)]
#[command(next_help_heading = "Environment")]
pub struct SceneArgs {
    /// Light from all around: an equirectangular map (.hdr, .exr or any picture) whose centre is straight ahead of the
    /// default camera, or sky, which is built in; it does not turn with the camera
    #[arg(long, value_name = "MAP")]
    env: Option<PathBuf>,
    #[command(flatten)]
    adjustment: Adjustment,
    /// Add up N directions of the map at each point, drawn by their light, instead of the fast prefiltered form
    /// [default N: 256]
    #[arg(long, value_name = "N", num_args = 0..=1, require_equals = true, requires = "env")]
    env_samples: Option<Option<usize>>,
    /// Another seed draws other directions [default: 0]
    #[arg(long, value_name = "N", requires = "env_samples")]
    env_seed: Option<u64>,
}

/// The file of an environment, unless it is built in.
pub fn file(map: Option<&PathBuf>) -> Option<&Path> {
    map.map(PathBuf::as_path).filter(|path| *path != Path::new(SKY))
}

/// Reads a map, or makes the built-in one.
pub fn read(map: &Path, adjustment: &Adjustment, job: &Job) -> Result<Environment> {
    let environment = if map == Path::new(SKY) {
        Environment::sky(job)?
    } else {
        let raster = input::raster(map, job)?;
        // The samples as read, as planes, and as the map.
        job.check("the environment map", raster.size(), 4 * 3 * raster.channels() as u64)?;
        Environment::new(&raster.to_picture(Space::Linear), &job.about(map)).map_err(|e| e.at(map))?
    };
    environment.adjusted(adjustment.env_rotate.to_radians(), adjustment.env_strength)
}

/// What a report says of a map.
pub fn described(map: &Path, adjustment: &Adjustment) -> Value {
    json!({
        "map": paths::text(map),
        "rotation_deg": adjustment.env_rotate,
        "strength": adjustment.env_strength,
    })
}

impl SceneArgs {
    /// The file of the map, if there is one.
    pub fn file(&self) -> Option<&Path> {
        file(self.env.as_ref())
    }

    /// Whether the scene has an environment.
    pub fn is_given(&self) -> bool {
        self.env.is_some()
    }

    fn method(&self) -> EnvironmentMethod {
        match self.env_samples {
            None => EnvironmentMethod::Prefiltered,
            Some(samples) => EnvironmentMethod::Sampled {
                samples: samples.unwrap_or(SAMPLES),
                seed: self.env_seed.unwrap_or_default(),
            },
        }
    }

    /// Reads the environment, if one is given.
    pub fn read(&self, job: &Job) -> Result<Option<EnvironmentLight>> {
        let Some(map) = &self.env else { return Ok(None) };
        let environment = read(map, &self.adjustment, job)?;
        Ok(Some(EnvironmentLight { environment, method: self.method() }))
    }

    /// What the report says of it; null where there is none.
    pub fn described(&self) -> Value {
        let Some(map) = &self.env else { return Value::Null };
        let mut said = described(map, &self.adjustment);
        match self.method() {
            EnvironmentMethod::Prefiltered => said["method"] = json!("prefiltered"),
            EnvironmentMethod::Sampled { samples, seed } => {
                said["method"] = json!("sampled");
                said["samples"] = json!(samples);
                said["seed"] = json!(seed);
            }
        }
        said
    }
}
