//! Built-in procedural materials.
