//! PLY files (Turk 1994), text or binary: vertices and polygons; everything else is skipped.

use nalgebra::Vector3;

use super::Triangles;

/// Encoding of the numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Encoding {
    Text,
    Little,
    Big,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Number {
    Signed(usize),
    Unsigned(usize),
    Float(usize),
}

enum Property {
    Scalar(String, Number),
    List(String, [Number; 2]),
}

struct Element {
    name: String,
    count: usize,
    properties: Vec<Property>,
}

/// Reads the bytes of a PLY file. Errors are half a sentence that states the problem.
pub(crate) fn read(bytes: &[u8]) -> Result<Triangles, String> {
    let (encoding, elements, body) = header(bytes)?;
    let mut values = Values {
        encoding,
        rest: body,
    };
    let mut soup = Triangles::default();
    for element in &elements {
        for row in 0..element.count {
            let at = |problem: String| format!("{problem} in {} {row}", element.name);
            let (point, polygon) = values.row(element).map_err(at)?;
            match element.name.as_str() {
                "vertex" => soup.vertices.push(point),
                "face" => soup.polygon(&polygon),
                _ => {}
            }
        }
    }
    Ok(soup)
}

fn header(bytes: &[u8]) -> Result<(Encoding, Vec<Element>, &[u8]), String> {
    const LONGEST: usize = 1 << 16;
    let head = &bytes[..bytes.len().min(LONGEST)];
    let end = b"end_header";
    let place = head
        .windows(end.len())
        .position(|window| window == end)
        .ok_or("its header has no end_header")?;
    let text = str::from_utf8(&head[..place])
        .map_err(|error| format!("its header is not text: {error}"))?;
    // Only one line end, LF or CR LF, is skipped, because the rest may be binary.
    let after = &bytes[place + end.len()..];
    let body = after
        .strip_prefix(b"\r\n")
        .or_else(|| after.strip_prefix(b"\n"))
        .or_else(|| after.strip_prefix(b"\r"))
        .ok_or("its header does not end with a line")?;
    let (encoding, elements) = declarations(text)?;
    Ok((encoding, elements, body))
}

/// The encoding and the elements that the lines of a header declare.
fn declarations(text: &str) -> Result<(Encoding, Vec<Element>), String> {
    let mut lines = text.lines();
    if lines.next().map(str::trim) != Some("ply") {
        return Err("it does not begin with `ply`".to_owned());
    }
    let mut encoding = None;
    let mut elements: Vec<Element> = Vec::new();
    for line in lines {
        let words: Vec<&str> = line.split_whitespace().collect();
        let unknown = || format!("its header has `{}`", line.trim());
        match words[..] {
            [] | ["comment" | "obj_info", ..] => {}
            ["format", name, _] => {
                encoding = Some(match name {
                    "ascii" => Encoding::Text,
                    "binary_little_endian" => Encoding::Little,
                    "binary_big_endian" => Encoding::Big,
                    _ => return Err(unknown()),
                });
            }
            ["element", name, count] => elements.push(Element {
                name: name.to_owned(),
                count: count.parse().ok().ok_or_else(unknown)?,
                properties: Vec::new(),
            }),
            ["property", ref rest @ ..] => {
                let property = property(rest).ok_or_else(unknown)?;
                let element = elements.last_mut().ok_or_else(unknown)?;
                element.properties.push(property);
            }
            _ => return Err(unknown()),
        }
    }
    let encoding = encoding.ok_or("its header names no format")?;
    for element in &elements {
        if element.properties.is_empty() && element.count > 0 {
            return Err(format!("element {} has no properties", element.name));
        }
    }
    Ok((encoding, elements))
}

fn property(words: &[&str]) -> Option<Property> {
    match *words {
        ["list", count, item, name] => {
            let kinds = [number(count)?, number(item)?];
            Some(Property::List(name.to_owned(), kinds))
        }
        [kind, name] => Some(Property::Scalar(name.to_owned(), number(kind)?)),
        _ => None,
    }
}

fn number(name: &str) -> Option<Number> {
    Some(match name {
        "char" | "int8" => Number::Signed(1),
        "short" | "int16" => Number::Signed(2),
        "int" | "int32" => Number::Signed(4),
        "uchar" | "uint8" => Number::Unsigned(1),
        "ushort" | "uint16" => Number::Unsigned(2),
        "uint" | "uint32" => Number::Unsigned(4),
        "float" | "float32" => Number::Float(4),
        "double" | "float64" => Number::Float(8),
        _ => return None,
    })
}

/// The numbers after the header.
struct Values<'a> {
    encoding: Encoding,
    rest: &'a [u8],
}

impl Values<'_> {
    /// The position and the polygon of a row, if it has them.
    fn row(&mut self, element: &Element) -> Result<(Vector3<f64>, Vec<u32>), String> {
        let mut point = Vector3::zeros();
        let mut polygon = Vec::new();
        for property in &element.properties {
            match property {
                Property::Scalar(name, kind) => {
                    let value = self.number(*kind)?;
                    match name.as_str() {
                        "x" => point.x = value,
                        "y" => point.y = value,
                        "z" => point.z = value,
                        _ => {}
                    }
                }
                Property::List(name, [count, item]) => {
                    let count = self.index(*count)?;
                    let wanted = matches!(name.as_str(), "vertex_indices" | "vertex_index");
                    for _ in 0..count {
                        if wanted {
                            polygon.push(self.index(*item)?);
                        } else {
                            self.number(*item)?;
                        }
                    }
                }
            }
        }
        Ok((point, polygon))
    }

    fn index(&mut self, kind: Number) -> Result<u32, String> {
        let value = self.number(kind)?;
        if value.fract() != 0.0 || !(0.0..=f64::from(u32::MAX)).contains(&value) {
            return Err(format!("it has {value} where a whole number is needed"));
        }
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "checked above"
        )]
        Ok(value as u32)
    }

    fn number(&mut self, kind: Number) -> Result<f64, String> {
        let ended = || "it ends early".to_owned();
        if self.encoding == Encoding::Text {
            let start = self
                .rest
                .iter()
                .position(|byte| !byte.is_ascii_whitespace());
            let rest = &self.rest[start.ok_or_else(ended)?..];
            let end = rest.iter().position(u8::is_ascii_whitespace);
            let (word, rest) = rest.split_at(end.unwrap_or(rest.len()));
            self.rest = rest;
            let word = String::from_utf8_lossy(word);
            let number = word.parse().ok();
            return number.ok_or_else(|| format!("it has `{word}` where a number is needed"));
        }
        let (Number::Signed(size) | Number::Unsigned(size) | Number::Float(size)) = kind;
        let (head, rest) = self.rest.split_at_checked(size).ok_or_else(ended)?;
        self.rest = rest;
        let mut bytes = [0; 8];
        bytes[..size].copy_from_slice(head);
        if self.encoding == Encoding::Big {
            bytes[..size].reverse();
        }
        let bits = u64::from_le_bytes(bytes);
        let [b0, b1, b2, b3, ..] = bytes;
        Ok(match kind {
            Number::Unsigned(_) => bits as f64,
            Number::Signed(1) => f64::from(i8::from_le_bytes([b0])),
            Number::Signed(2) => f64::from(i16::from_le_bytes([b0, b1])),
            Number::Signed(_) => f64::from(i32::from_le_bytes([b0, b1, b2, b3])),
            Number::Float(4) => f64::from(f32::from_le_bytes([b0, b1, b2, b3])),
            Number::Float(_) => f64::from_bits(bits),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEAD: &str = "ply\nformat FORMAT 1.0\ncomment a wedge\nelement vertex 4\nproperty float x\nproperty float y\n\
        property double z\nproperty uchar red\nelement face 3\nproperty uchar quality\n\
        property list uchar int vertex_indices\nend_header\n";
    const POINTS: [[f32; 3]; 4] = [[0.0; 3], [0.5, 0.0, 0.0], [0.0, 0.25, 0.0], [0.0, 0.0, 1.0]];
    const FACES: [&[i32]; 3] = [&[0, 2, 1], &[0, 1, 3], &[1, 2, 3, 0]];

    fn binary(big: bool) -> Vec<u8> {
        let format = if big {
            "binary_big_endian"
        } else {
            "binary_little_endian"
        };
        let mut bytes = HEAD.replace("FORMAT", format).into_bytes();
        let mut add = |mut number: Vec<u8>| {
            if big {
                number.reverse();
            }
            bytes.extend(number);
        };
        for [x, y, z] in POINTS {
            add(x.to_le_bytes().to_vec());
            add(y.to_le_bytes().to_vec());
            add(f64::from(z).to_le_bytes().to_vec());
            add(vec![7]);
        }
        for face in FACES {
            add(vec![9]);
            add(vec![u8::try_from(face.len()).unwrap()]);
            for corner in face {
                add(corner.to_le_bytes().to_vec());
            }
        }
        bytes
    }

    #[test]
    fn text_and_both_binary_forms_are_read() {
        use std::fmt::Write;
        let mut text = HEAD.replace("FORMAT", "ascii");
        for [x, y, z] in POINTS {
            writeln!(text, "{x} {y} {z} 255").unwrap();
        }
        for face in FACES {
            let corners: Vec<String> = face.iter().map(ToString::to_string).collect();
            writeln!(text, "1 {} {}", face.len(), corners.join(" ")).unwrap();
        }
        let soup = read(text.as_bytes()).unwrap();
        assert_eq!(soup.vertices[3], Vector3::new(0.0, 0.0, 1.0));
        assert_eq!(soup.triangles, [[0, 2, 1], [0, 1, 3], [1, 2, 3], [1, 3, 0]]);
        for big in [false, true] {
            let same = read(&binary(big)).unwrap();
            assert_eq!(
                (same.vertices, same.triangles),
                (soup.vertices.clone(), soup.triangles.clone())
            );
        }
    }
}
