//! Text and pictures of pages: escaped, and as data URIs.

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

/// Text escaped for HTML.
pub fn escaped(text: &str) -> String {
    let mut html = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => html.push_str("&amp;"),
            '<' => html.push_str("&lt;"),
            '>' => html.push_str("&gt;"),
            '"' => html.push_str("&quot;"),
            '\'' => html.push_str("&#39;"),
            // Names must not introduce marks of the template.
            '{' => html.push_str("&#123;"),
            c => html.push(c),
        }
    }
    html
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_text_becomes_markup() {
        assert_eq!(escaped("<a href='x'>&\"{{"), "&lt;a href=&#39;x&#39;&gt;&amp;&quot;&#123;&#123;");
    }
}
