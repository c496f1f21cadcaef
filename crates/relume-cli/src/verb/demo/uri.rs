//! Pictures as data URIs for a page.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use relume::format::{Depth, PictureFormat, encode_picture};
use relume::{Picture, Result};

/// The bytes of a PNG file as a data URI.
pub fn png_uri(bytes: &[u8]) -> String {
    format!("data:image/png;base64,{}", STANDARD.encode(bytes))
}

/// A picture as the data URI of a PNG file of 8 bits.
pub fn picture_uri(picture: &Picture) -> Result<String> {
    Ok(png_uri(&encode_picture(picture, PictureFormat::Png(Depth::Eight))?))
}
