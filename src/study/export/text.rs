//! Numbers, names and meshes in the texts of models.

use nalgebra::Vector3;

use super::ExportedFile;
use crate::figure::MAKER;

/// Numbers separated by spaces, with every bit.
pub(super) fn numbers<'a>(values: impl IntoIterator<Item = &'a f64>) -> String {
    // Adding zero turns −0 into 0.
    let texts: Vec<String> = values.into_iter().map(|x| (x + 0.0).to_string()).collect();
    texts.join(" ")
}

/// A name as the value of an XML attribute.
pub(super) fn name(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for letter in text.chars() {
        match letter {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            // XML has no way to write the other control characters.
            letter if letter.is_control() => escaped.push('_'),
            letter => escaped.push(letter),
        }
    }
    escaped
}

/// Text that is safe inside an XML comment.
pub(super) fn comment(text: &str) -> String {
    name(text).replace("--", "- -")
}

/// A mesh as an OBJ file.
pub(super) fn obj(file: String, vertices: &[Vector3<f64>], triangles: &[[u32; 3]]) -> ExportedFile {
    let text = crate::formats::obj::write(vertices, triangles, |v| numbers(v));
    ExportedFile {
        name: file,
        bytes: format!("# Made by {MAKER}.\n{text}").into_bytes(),
    }
}
