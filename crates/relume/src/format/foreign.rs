//! Files of other programs that are not read, so that a refusal names them and says what to do.

/// What the bytes of a file are, in words, and what is to be made of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Foreign {
    /// The kind, with its article.
    pub name: &'static str,
    /// What to do instead.
    pub advice: &'static str,
}

const PICTURE: &str = "export the picture as PNG, TIFF or EXR";
const MESH: &str = "export the mesh as .glb or .obj";
const RAW: &str = "develop the photographs to TIFF or PNG, all with the same settings";

/// Bytes at an offset, and what begins so.
const SIGNATURES: [(usize, &[u8], &str, &str); 21] = [
    (4, b"jP  \r\n\x87\n", "a JPEG 2000 picture", PICTURE),
    (0, b"\xff\x4f\xff\x51", "a JPEG 2000 picture", PICTURE),
    (0, b"\xff\x0a", "a JPEG XL picture", PICTURE),
    (4, b"JXL \r\n\x87\n", "a JPEG XL picture", PICTURE),
    (8, b"WEBPVP8", "a WebP picture", PICTURE),
    (0, b"BM", "a BMP picture", PICTURE),
    (0, b"GIF8", "a GIF picture", PICTURE),
    (0, b"DDS ", "a DDS texture", PICTURE),
    (0, b"8BPS\0", "a Photoshop document", PICTURE),
    (4, b"ftypavif", "an AVIF picture", PICTURE),
    (4, b"ftyphei", "a HEIC picture", PICTURE),
    (4, b"ftypmif1", "a HEIF picture", PICTURE),
    (0, b"qoif", "a QOI picture", PICTURE),
    (0, b"%PDF-", "a PDF document", PICTURE),
    (0, b"gimp xcf", "a GIMP document", PICTURE),
    (4, b"ftypcrx", "a camera's raw file (CR3)", RAW),
    (0, b"FUJIFILMCCD-RAW", "a camera's raw file (RAF)", RAW),
    (0, b"ply\n", "a PLY mesh", MESH),
    (0, b"ply\r\n", "a PLY mesh", MESH),
    (0, b"Kaydara FBX Binary", "an FBX scene", MESH),
    (0, b"# vtk DataFile", "a VTK file", MESH),
];

/// Bytes that are looked at of a text.
const HEAD: usize = 4096;

/// The kind of a file that is not read, if it is known.
pub(super) fn of(bytes: &[u8]) -> Option<Foreign> {
    let begins = |at: usize, start: &[u8]| bytes.get(at..).is_some_and(|rest| rest.starts_with(start));
    let found = SIGNATURES.iter().find(|(at, start, ..)| begins(*at, start));
    let named = found.map(|&(_, _, name, advice)| Foreign { name, advice });
    named.or_else(|| {
        is_gltf_text(bytes).then_some(Foreign {
            name: "a glTF text with its buffers beside it",
            advice: "export it as one .glb",
        })
    })
}

fn is_gltf_text(bytes: &[u8]) -> bool {
    let head = &bytes[..bytes.len().min(HEAD)];
    let holds = |word: &[u8]| head.windows(word.len()).any(|window| window == word);
    head.trim_ascii_start().starts_with(b"{") && holds(b"\"asset\"") && holds(b"\"version\"")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn other_programs_files_are_named() {
        let cases: [(&[u8], &str); 5] = [
            (b"\0\0\0\x0cjP  \r\n\x87\n", "JPEG 2000"),
            (b"RIFF\x10\0\0\0WEBPVP8 ", "WebP"),
            (b"\0\0\0\x1cftypavif", "AVIF"),
            (b"ply\nformat ascii 1.0\n", "PLY"),
            (b" {\"asset\":{\"version\":\"2.0\"}}", "glTF"),
        ];
        for (bytes, name) in cases {
            assert!(of(bytes).unwrap().name.contains(name), "{name}");
        }
        assert_eq!(of(b"{\"width\":3}"), None);
        assert_eq!(of(b""), None);
    }
}
