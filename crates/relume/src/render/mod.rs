//! Pictures of fields: relighting, and rendering on objects.
