//! Reflectance textures: textures in which every texel is a function of light direction.
//!
//! ```text
//! photographs + lights --fit--> ReflectanceField --+-- synthesis --> SourceMap --gather--> ReflectanceField
//! .ptm .exr .png --format::read-> (any basis)      +-- random_field -> model ----sample--> ReflectanceField
//!                                                  +-- surface ----> normals, albedo
//! virtual dome ---capture--> photographs           +-- render -----> Picture --format::write--> file
//! ```
//!
//! From photographs under known lights to a larger texture, relit:
//!
//! ```
//! use relume::{Capture, Direction, FitOptions, Size, SynthOptions, fit, relight, synthesize};
//! # use relume::capture::dome::{Dome, DomeOptions, lights};
//! # use relume::procedural::{Material, MaterialOptions};
//! # let folder = tempfile::tempdir().unwrap();
//! # let small = MaterialOptions { size: Size::new(48, 48), feature: 12.0, ..Default::default() };
//! # let job = relume::Job::default();
//! # let dome = Dome::new(Material::Weave.make(&small, &job)?, &DomeOptions::default(), &job)?;
//! # relume::workflow::capture::save(&dome, &lights(8), folder.path(), &job)?;
//! # std::env::set_current_dir(folder.path()).unwrap();
//! # std::fs::rename("lights.lp", "wool.lp").unwrap();
//!
//! let capture = Capture::open("wool.lp")?;
//! let field = fit(&capture, &FitOptions::default())?.field;
//! let large = synthesize(&field, &SynthOptions { size: Size::new(64, 64), ..Default::default() })?;
//! relight(&large.field, Direction::new(0.5, 0.3, 0.8)?).save("large.png")?;
//! # assert_eq!(relume::ReflectanceField::open("large.png")?.size(), Size::new(64, 64));
//! # Ok::<(), relume::Error>(())
//! ```
//!
//! Everything is built around one type, [`field::ReflectanceField`]: a basis and planes of coefficients.
//! Stages map fields to fields or to pictures and do not know each other; [`workflow`] connects them.
//! Internally, values are `f32` with white at 1, x points right, y up, z to the viewer, and row 0 of every
//! plane is the top row. Fields and pictures record whether their values are linear or sRGB-encoded; other
//! encodings, quantisation and row orders exist only in [`mod@format`] and [`capture`].
//!
//! # Features
//! Heavy formats are optional; all are on by default. Without a feature, its files are refused by name.
//!
//! | feature | formats |
//! |---|---|
//! | `exr` | EXR pictures and fields |
//! | `gif` | animated GIF |
//! | `mesh` | binary glTF meshes |

// The foundation of everything else.
pub mod brdf;
mod clipping;
pub mod direction;
pub mod error;
pub mod job;
pub mod lab;
pub mod lamps;
pub mod limits;
pub mod maps;
mod memory;
pub mod microfacet;
pub mod names;
pub mod numeric;
mod parallel;
pub mod picture;
pub mod planes;
pub mod progress;
pub mod raster;
pub mod rect;
mod remarks;
pub mod size;
pub mod space;
pub mod stamp;
pub mod words;

// The central type.
pub mod field;

// Sources of fields.
pub mod capture;
pub mod fit;
pub mod procedural;
pub mod surface;

// From field to field.
pub mod random_field;
pub mod synthesis;

// Consumers of fields.
pub mod analysis;
pub mod format;
pub mod metric;
pub mod render;

// What joins the stages.
pub mod workflow;

pub use capture::Capture;
pub use direction::Direction;
pub use error::{Error, ErrorKind, Result};
pub use field::ReflectanceField;
pub use fit::FitOptions;
pub use job::{Cancel, Held, Job};
pub use limits::Limits;
pub use memory::Footprint;
pub use names::Named;
pub use picture::Picture;
pub use planes::Planes;
pub use progress::Progress;
pub use raster::{Raster, RasterSequence, Samples};
pub use rect::Rect;
pub use render::relight;
pub use size::Size;
pub use space::Space;
pub use stamp::Stamp;
pub use workflow::SynthOptions;
pub use workflow::front::{Synthesized, fit, fit_with, synthesize, synthesize_with};
