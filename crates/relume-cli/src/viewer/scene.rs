//! What textures are shown on and under, beside what the page has of its own.

use std::path::{Path, PathBuf};

use relume::format::read_mesh;
use relume::format::share::mesh;
use relume::render::Environment;
use relume::{Job, Result};

use crate::{environment, paths};

/// The object and the light of a page.
#[derive(Debug, clap::Args)]
pub struct PageSceneArgs {
    /// An object of your own beside the built-in ones: .obj or .glb with texture coordinates
    #[arg(long, value_name = "MESH")]
    mesh: Option<PathBuf>,
    /// Light from all around: an equirectangular map (.hdr, .exr or any picture), or sky, which is built in
    #[arg(long, value_name = "MAP", help_heading = "Environment")]
    env: Option<PathBuf>,
    #[command(flatten)]
    adjustment: environment::Adjustment,
}

/// The object and the light, read.
#[derive(Debug, Default)]
pub struct Scene {
    /// The name of the object and the file that the page loads.
    pub mesh: Option<(String, Vec<u8>)>,
    /// Light from all around.
    pub environment: Option<Environment>,
}

impl PageSceneArgs {
    /// The files that are read.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        self.mesh.as_deref().into_iter().chain(environment::file(self.env.as_ref()))
    }

    /// Reads both.
    pub fn read(&self, job: &Job) -> Result<Scene> {
        let mesh = self.mesh.as_deref().map(|path| -> Result<(String, Vec<u8>)> {
            let name = path.file_name().map_or_else(|| "mesh".to_owned(), paths::text);
            Ok((name, mesh::encode(&read_mesh(path, job)?)))
        });
        let environment = self.env.as_ref().map(|map| environment::read(map, &self.adjustment, job));
        Ok(Scene { mesh: mesh.transpose()?, environment: environment.transpose()? })
    }
}
