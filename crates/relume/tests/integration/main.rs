//! One test binary; each module tests one promise of the library.

mod appearance;
mod hsh_independent;
mod jpeg_complete;
mod layering;
mod names;

mod analysis;
mod bases_and_channels;
mod bonn_btf;
mod brdf_files;
mod btf_files;
mod cancellation;
mod circles;
mod distinct_names;
mod format_color;
mod format_opacity;
mod format_pictures;
mod format_robustness;
mod format_round_trips;
mod format_tiff;
mod goldens;
mod measured_brdf;
mod ptm_compressed;
mod ptm_independent;
mod ptm_precision;
mod random_field_promises;
mod random_fields;
mod real_captures;
mod rlm_independent;
mod roller;
mod stages;
mod support;
mod synthesis;
mod texture_measures;
mod tiling;
mod web_folders;
