//! The page around the script: one HTML file, with everything else beside it or inside.

use std::io::Write;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::GzEncoder;
use serde_json::Value;

use super::{SCRIPT, SCRIPT_NAME, STYLE, STYLE_NAME, THUMBNAIL_NAME};

const TEMPLATE: &str = include_str!("page/page.html");

/// What a page may load: files beside it and nothing else.
pub const FOLDER_POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; \
                                 connect-src 'self'; base-uri 'none'; form-action 'none'";
/// A page in one file loads nothing.
const SINGLE_POLICY: &str = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; \
                             img-src blob: data:; base-uri 'none'; form-action 'none'";

/// What the script finds in the page.
#[derive(Debug)]
pub struct PageData {
    /// The page's title.
    pub title: String,
    /// `textures`: a list of objects with a `title` and a `folder`, `files` in base64, or an `error`.
    pub textures: Value,
    /// `title` of the object and its `file`, or its `bytes` in base64; null where there is none.
    pub mesh: Value,
    /// The address at which the page will be.
    pub url: Option<String>,
}

/// A page with its files beside it.
pub fn folder_page(data: &PageData) -> String {
    // Other sites take addresses of pictures as they are: only whole ones lead anywhere.
    let base = data.url.as_deref().map(|url| format!("{}/", url.trim_end_matches('/'))).unwrap_or_default();
    let image = escaped(&format!("{base}{THUMBNAIL_NAME}"));
    let head = format!(
        "{}<meta property=\"og:image\" content=\"{image}\">\n<meta name=\"twitter:card\" content=\"summary_large_image\">\n\
         <link rel=\"icon\" href=\"data:,\">\n<link rel=\"stylesheet\" href=\"{STYLE_NAME}\">",
        link_tags(data)
    );
    let script = format!("<script src=\"{SCRIPT_NAME}\"></script>");
    filled(data, FOLDER_POLICY, &head, &script)
}

/// A page with its textures inside, and script and style sheet, which other pages may share, beside it: opens from disk.
pub fn disk_page(data: &PageData) -> String {
    let head =
        format!("<link rel=\"icon\" href=\"data:,\">\n<link rel=\"stylesheet\" href=\"{STYLE_NAME}\">");
    let script = format!("<script src=\"{SCRIPT_NAME}\"></script>");
    filled(data, FOLDER_POLICY, &head, &script)
}

/// What other sites show of a link to the page.
fn link_tags(data: &PageData) -> String {
    let names: Vec<&str> =
        data.textures.as_array().into_iter().flatten().filter_map(|t| t["title"].as_str()).collect();
    let description = format!("{}: move the light and look closely.", names.join(", "));
    let tag = |name: &str, content: &str| {
        format!("<meta property=\"og:{name}\" content=\"{}\">\n", escaped(content))
    };
    let url = data.url.as_deref().map(|url| tag("url", url)).unwrap_or_default();
    tag("type", "website") + &tag("title", &data.title) + &tag("description", &description) + &url
}

/// Unpacks the script of a page in one file, which is a quarter as long compressed.
const UNPACK: &str = "const packed = Uint8Array.from(atob(document.getElementById(\"relume-script\").textContent), (c) => \
                      c.charCodeAt(0));\n\
                      new Response(new Blob([packed]).stream().pipeThrough(new DecompressionStream(\"gzip\"))).text().then((text) => {\n  \
                      document.body.append(Object.assign(document.createElement(\"script\"), { textContent: text }));\n});";

/// A page in one file.
pub fn single_page(data: &PageData) -> String {
    let head = format!("{}<link rel=\"icon\" href=\"data:,\">\n<style>{STYLE}</style>", link_tags(data));
    let mut packed = GzEncoder::new(Vec::new(), Compression::best());
    packed.write_all(SCRIPT.as_bytes()).expect("memory takes all bytes");
    let packed = STANDARD.encode(packed.finish().expect("memory takes all bytes"));
    let script = format!(
        "<script type=\"application/octet-stream\" id=\"relume-script\">{packed}</script>\n<script>{UNPACK}</script>"
    );
    filled(data, SINGLE_POLICY, &head, &script)
}

/// What the script finds in a page.
#[derive(serde::Serialize)]
struct ShownData<'a> {
    title: &'a str,
    textures: &'a Value,
    mesh: &'a Value,
}

/// The template with its fields filled in, one after another, so that no value is taken for a field.
fn filled(data: &PageData, policy: &str, head: &str, script: &str) -> String {
    let title = escaped(&data.title);
    let shown = ShownData { title: &data.title, textures: &data.textures, mesh: &data.mesh };
    // In a script element only the beginning of a tag could end the data.
    let json = serde_json::to_string(&shown).expect("texts and numbers").replace('<', "\\u003c");
    let fields =
        [("policy", policy), ("title", &*title), ("head", head), ("data", &*json), ("script", script)];
    let mut page = String::new();
    let mut rest = TEMPLATE;
    for (name, value) in fields {
        let (before, after) = rest.split_once(&format!("{{{{{name}}}}}")).expect("the fields in their order");
        page.push_str(before);
        page.push_str(value);
        rest = after;
    }
    page + rest
}

/// A text in an element or a quoted attribute.
fn escaped(text: &str) -> String {
    let replaced = |c: char| match c {
        '&' => "&amp;".to_owned(),
        '<' => "&lt;".to_owned(),
        '>' => "&gt;".to_owned(),
        '"' => "&quot;".to_owned(),
        '\'' => "&#39;".to_owned(),
        other => other.to_string(),
    };
    text.chars().map(replaced).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn titles_cannot_leave_their_places() {
        let title = "</title><script>alert(1)</script>\"{{script}}".to_owned();
        let textures = serde_json::json!([{ "title": title, "error": "</script><!--" }]);
        for page in [folder_page, disk_page, single_page] {
            let data =
                PageData { title: title.clone(), textures: textures.clone(), mesh: Value::Null, url: None };
            let page = page(&data);
            assert!(!page.contains("<script>alert"), "a title became a script");
            assert!(!page.contains("</script><!--"), "an error ended the data");
            let json = page.split_once("id=\"relume-data\">").unwrap().1.split_once("</script>").unwrap().0;
            let read: Value = serde_json::from_str(json).unwrap();
            assert_eq!(read["title"], title.as_str());
        }
    }
}
