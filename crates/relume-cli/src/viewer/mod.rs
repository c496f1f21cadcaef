//! The viewer: a page that shows textures under moving light, as a folder, as one file, or from a local server.
//!
//! The page is built from `web/` by Vite and committed in `page/`, so that building the program needs no Node.

mod annotations;
mod html;
mod scene;
mod textures;
mod titles;

pub use annotations::{
    AnnotationFile, MOST_BYTES, followed as followed_links, place as annotation_place,
    save as save_annotations,
};
pub use html::{FOLDER_POLICY, PageData, disk_page, folder_page, single_page};
pub use scene::{PageSceneArgs, Scene};
pub use textures::{Delivery, PlaneArgs, Preparation, Prepared, ServedPlane, TextureSource, sources};

/// The page's script.
pub const SCRIPT: &str = include_str!("page/viewer.js");
/// The element `<relume-view>` for other pages.
pub const ELEMENT: &str = include_str!("page/relume-view.js");
/// The page's style sheet.
pub const STYLE: &str = include_str!("page/viewer.css");

/// The name of the script beside the page.
pub const SCRIPT_NAME: &str = "viewer.js";
/// The name of the element's script beside the page.
pub const ELEMENT_NAME: &str = "relume-view.js";
/// The name of the style sheet beside the page.
pub const STYLE_NAME: &str = "viewer.css";
/// The name of the object beside the page.
pub const MESH_NAME: &str = "mesh.gz";
/// The name of the picture for links.
pub const THUMBNAIL_NAME: &str = "thumbnail.jpg";
