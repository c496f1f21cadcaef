//! One test binary; each module runs verbs of the program as a user does.

mod auto;
mod btf;
mod btf_forms;
mod btf_input;
mod btf_models;
mod btf_words;
mod capture;
mod channels;
mod compare_analyze;
mod convert;
mod demo;
mod elements;
mod everything;
mod extremes;
mod faults;
mod fill;
mod films;
mod fit;
mod gallery;
mod gonioreflectometer;
mod height;
mod held_out;
mod kills;
mod lights;
mod maps;
#[cfg(target_os = "linux")]
mod memory;
mod model;
mod new;
mod new_commands;
mod one_door;
mod outputs;
mod procedural;
mod readme;
mod relight_render;
mod roll;
mod signals;
mod sizes;
mod support;
mod synth;
#[cfg(unix)]
mod viewer;
