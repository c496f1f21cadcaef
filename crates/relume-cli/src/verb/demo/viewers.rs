//! The pages of the viewer beside that of the demo: each opens from disk and alone, and all share one script.

use relume::Result;
use relume::format::share::ShareHeader;
use serde_json::{Value, json};

use crate::context::Context;
use crate::evaluated;
use crate::output::Folder;
use crate::viewer::{self, Delivery, PageData, PlaneArgs, Preparation, TextureSource};

/// A page, the file that it shows, its title, and whether as noise.
const PAGES: [(&str, &str, &str, bool); 4] = [
    ("texture.html", "large.ptm", "A texture of functions", false),
    ("tiles.html", "tiles.ptm", "An endless regular texture", false),
    ("noise.html", "noise.ptm", "An endless stochastic texture", true),
    ("light_view.html", "light_view_tiles.exr", "A texture of light and view", false),
];

/// What the page of the demo says of the noise.
#[derive(Debug)]
pub struct Viewers {
    /// The exemplar of the noise in texels, as people write it.
    pub noise_size: String,
    /// The planes that are blended.
    pub noise_planes: usize,
}

/// Writes the pages into the folder of the demo.
pub fn write(folder: &Folder, context: &Context) -> Result<Viewers> {
    let mut said = Viewers { noise_size: String::new(), noise_planes: 0 };
    for (page, file, title, noise) in PAGES {
        let (planes, evaluated) = (PlaneArgs::usual(noise), evaluated::Args::default());
        let preparation = Preparation {
            planes: &planes,
            evaluated: &evaluated,
            environment: None,
            delivery: Delivery::Stored,
        };
        let source =
            TextureSource { path: &folder.path().join(file), title: title.to_owned(), mm_per_texel: None };
        let texture = preparation.prepared(source, &context.job)?;
        if let Some(noise) = &texture.header.noise {
            let ShareHeader { size: [width, height], .. } = texture.header;
            said = Viewers { noise_size: format!("{width} x {height}"), noise_planes: noise.planes };
        }
        let textures = json!([{ "title": title, "files": texture.in_base64() }]);
        let data = PageData { title: title.to_owned(), textures, mesh: Value::Null, url: None };
        folder.add(page, viewer::disk_page(&data).as_bytes())?;
    }
    folder.add(viewer::SCRIPT_NAME, viewer::SCRIPT.as_bytes())?;
    folder.add(viewer::STYLE_NAME, viewer::STYLE.as_bytes())?;
    Ok(said)
}
