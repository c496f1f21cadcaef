//! Normal maps of verbs that read or write them: one option, and the words.

use std::path::Path;

use relume::format::NormalY;

use crate::args;

/// The option of verbs with normal maps.
#[derive(Debug, Clone, clap::Args)]
#[group(skip)]
pub struct Args {
    /// Direction of the green channel of all normal maps read and written: up (OpenGL) or down (DirectX)
    /// [default: by the record in the file, else by its name (_gl, _dx), else up]
    #[arg(long, value_name = "Y", value_parser = args::named::<NormalY>())]
    pub normal_y: Option<NormalY>,
}

/// The option of verbs that read normal maps, and write what others want.
#[derive(Debug, Clone, clap::Args)]
#[group(skip)]
pub struct ReadArgs {
    /// Direction of the green channel of the normal map that is read: up (OpenGL) or down (DirectX)
    /// [default: by the record in the file, else by its name (_gl, _dx), else up]
    #[arg(long, value_name = "Y", value_parser = args::named::<NormalY>())]
    pub normal_y: Option<NormalY>,
}

impl Args {
    /// The direction in which a file is written.
    pub fn of_output(&self, path: &Path) -> NormalY {
        self.normal_y.or(NormalY::of_name(path)).unwrap_or_default()
    }
}

/// What is said of a written normal map.
pub fn described(y: NormalY) -> String {
    format!("normals ({})", y.in_words())
}
