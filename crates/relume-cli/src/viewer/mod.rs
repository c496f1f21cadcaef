//! The viewer: a page that shows textures under moving light, as a folder, as one file, or from a local server.
//!
//! The page is built from `web/` by Vite and committed in `page/`, so that building the program needs no Node.

mod html;
mod textures;

pub use html::{FOLDER_POLICY, PageData, disk_page, folder_page, single_page};
pub use textures::{Delivery, PlaneArgs, Prepared, ServedPlane, prepared};

/// The page's script.
pub const SCRIPT: &str = include_str!("page/viewer.js");
/// The page's style sheet.
pub const STYLE: &str = include_str!("page/viewer.css");

/// The name of the script beside the page.
pub const SCRIPT_NAME: &str = "viewer.js";
/// The name of the style sheet beside the page.
pub const STYLE_NAME: &str = "viewer.css";
/// The name of the picture for links.
pub const THUMBNAIL_NAME: &str = "thumbnail.jpg";
