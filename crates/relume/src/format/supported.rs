//! What is read and written, with limits: one table for the program and the documentation.

use serde::Serialize;

/// A file format, or a kind of folder.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct SupportedFormat {
    /// Its usual name.
    pub name: &'static str,
    /// Of its files; recognition is by content.
    pub extensions: &'static [&'static str],
    /// What it holds.
    pub holds: &'static str,
    /// What of it is read; empty if nothing.
    pub read: &'static str,
    /// What of it is written; empty if nothing.
    pub written: &'static str,
    /// What is refused or lost.
    pub limits: &'static str,
}

macro_rules! formats {
    ($($name:literal [$($extension:literal),*] $holds:literal, $read:literal, $written:literal, $limits:literal;)+) => {
        &[$(SupportedFormat {
            name: $name,
            extensions: &[$($extension),*],
            holds: $holds,
            read: $read,
            written: $written,
            limits: $limits,
        }),+]
    };
}

/// All formats.
pub const SUPPORTED: &[SupportedFormat] = formats! {
    "PTM" ["ptm"] "functions", "1.0, 1.1, 1.2: RGB, LRGB, JPEG_RGB, JPEG_LRGB, LUM", "1.2: RGB, LRGB, JPEG_RGB, JPEG_LRGB",
        "8 bits, sRGB-encoded; look-up tables, JPEG-LS and prediction by motion are refused";
    "RTI" ["rti"] "functions", "harmonics, RGB and luminance times colour", "the same",
        "8 bits, sRGB-encoded; types other than 3 are refused";
    "HSH" ["hsh"] "functions", "harmonics, RGB", "the same", "8 bits, sRGB-encoded";
    "Relight web folder" [] "functions",
        "ptm, hsh, sh, rbf, bilinear; rgb, lrgb, mrgb, mycc; plain, deepzoom, tarzoom, itarzoom",
        "ptm, hsh, sh; rgb, lrgb; plain, deepzoom, tarzoom, itarzoom",
        "8 bits as JPEG; neural, ycc, zoomify, google and iiif are refused";
    "older web RTI viewer" ["xml"] "functions", "info.xml with LRGB_PTM, RGB_PTM, HSH_RTI, IMAGE; tiles as jpg and png",
        "LRGB_PTM, RGB_PTM, HSH_RTI of 4 and 9 terms; tiles of 256 as jpg", "8 bits";
    "EXR field" ["exr"] "functions", "all bases and channels", "the same", "half or float";
    "NumPy" ["npz", "npy"] "functions", "source maps (int32)", "coefficients, names and directions (npz); coefficients (npy)",
        "fields are not read back";
    "RLM" ["rlm"] "models", "versions 1 to 6", "the lowest version that fits", "";
    "UBO2014" ["btf"] "light and view", "DFMF, FMF, PVF, BDI", "DFMF, FMF, PVF (fit)", "bzip blocks are refused";
    "photographs by angles" ["zip"] "light and view", "UBO2003, UTIA, SPECTRAL names", "UBO2003 names", "";
    "BRDF" ["binary", "bin", "bsdf"] "reflectances", "MERL, UTIA, RGL", "", "";
    "PNG" ["png"] "pictures", "1 to 16 bits", "8 and 16 bits", "";
    "JPEG" ["jpg", "jpeg"] "pictures", "8 bits, grey and colour", "8 bits, full colour resolution",
        "no opacity; arithmetic coding and lossless JPEG are refused";
    "TIFF" ["tif", "tiff"] "pictures", "8 to 64 bits, BigTIFF, CMYK interleaved", "8 and 16 bits", "CMYK in planes is refused";
    "EXR" ["exr"] "pictures", "half, float, unsigned", "half, float", "linear";
    "PFM" ["pfm"] "pictures", "grey and colour", "the same", "no opacity; linear";
    "Radiance" ["hdr", "pic"] "pictures", "RGBE", "RGBE", "no opacity; linear";
    "APNG, GIF" ["png", "gif"] "animations", "", "8 bits; 256 colours", "";
    "light positions" ["lp"] "captures", "names and vectors", "the same", "";
    "OBJ" ["obj"] "meshes", "polygons", "", "materials are left out";
    "glTF" ["glb"] "meshes", "binary, without compression", "previews of materials, with functions in RELUME_reflectance",
        "text files (.gltf) and PLY are refused; materials are not read";
    "KTX2" ["ktx2"] "textures", "", "8 bits and BC7, with all levels", "2D; not supercompressed";
    "MaterialX" ["mtlx"] "materials", "", "1.39, OpenPBR", "heights are not connected";
    "USD" ["usda"] "materials", "", "preview surface", "heights are not connected";
};

#[cfg(test)]
mod tests {
    use super::*;
    use crate::format::FieldFormat;
    use std::path::Path;

    #[test]
    fn every_extension_of_fields_that_is_written_is_listed_as_such() {
        for extension in
            ["ptm", "rti", "hsh", "exr", "png", "jpg", "jpeg", "tif", "tiff", "pfm", "hdr", "pic"]
        {
            assert!(FieldFormat::from_path(Path::new(&format!("a.{extension}"))).is_ok());
            let listed = SUPPORTED.iter().any(|f| f.extensions.contains(&extension) && !f.written.is_empty());
            assert!(listed, "{extension}");
        }
    }

    #[test]
    fn every_format_is_read_or_written() {
        assert!(SUPPORTED.iter().all(|format| !format.read.is_empty() || !format.written.is_empty()));
    }
}
