//! What the values of a picture are read as.

/// Colours, or numbers that only look like colours.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Meaning {
    /// Colours: converted from the space that the file names to that of the project.
    Colors,
    /// Data, such as normals, heights, roughness, masks and labels: never converted.
    Data,
    /// Whatever registered images hold, to be stored again as it was: never converted, and a file that names
    /// another space becomes a remark.
    Copies,
}
