//! numpy's `.npy` files (NEP 1): a header in Python's notation, then numbers or a pickle.

use super::pickle::{Heap, Id, load};

const MAGIC: &[u8] = b"\x93NUMPY";

/// The type of an array's items.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Type {
    Object,
    Number { kind: u8, size: usize, big: bool },
}

impl Type {
    /// Reads a type as numpy writes it: `<f8`, `|O`, `i4`.
    pub(super) fn parse(code: &str) -> Result<Self, String> {
        let unknown = || format!("its items are of type {code}; numbers or objects are needed");
        let plain = code.trim_start_matches(['<', '>', '=', '|']);
        let mut letters = plain.chars();
        let kind = letters.next().ok_or_else(unknown)?;
        if kind == 'O' {
            return Ok(Self::Object);
        }
        let size: usize = letters.as_str().parse().ok().ok_or_else(unknown)?;
        let known = matches!(
            (kind, size),
            ('f', 4 | 8) | ('i' | 'u', 1 | 2 | 4 | 8) | ('b', 1)
        );
        let kind = u8::try_from(kind)
            .ok()
            .filter(|_| known)
            .ok_or_else(unknown)?;
        Ok(Self::Number {
            kind,
            size,
            big: code.starts_with('>'),
        })
    }

    /// The same with the byte order `<`, `>` or none.
    pub(super) fn ordered(self, order: &str) -> Self {
        match self {
            Self::Number { kind, size, .. } => Self::Number {
                kind,
                size,
                big: order == ">",
            },
            Self::Object => self,
        }
    }

    /// The first `count` numbers in `bytes`.
    pub(super) fn numbers(self, bytes: &[u8], count: usize) -> Result<Vec<f64>, String> {
        let Self::Number { kind, size, big } = self else {
            return Err("it has objects where numbers are needed".to_owned());
        };
        let needed = count.checked_mul(size);
        let bytes = needed.and_then(|needed| bytes.get(..needed));
        let bytes =
            bytes.ok_or_else(|| format!("it is cut short: {count} numbers are announced"))?;
        let number = |item: &[u8]| {
            let mut word = [0; 8];
            word[..size].copy_from_slice(item);
            if big {
                word[..size].reverse();
            }
            let bits = u64::from_le_bytes(word);
            let [b0, b1, b2, b3, ..] = word;
            match (kind, size) {
                (b'f', 4) => f64::from(f32::from_le_bytes([b0, b1, b2, b3])),
                (b'f', _) => f64::from_bits(bits),
                (b'i', 1) => f64::from(i8::from_le_bytes([b0])),
                (b'i', 2) => f64::from(i16::from_le_bytes([b0, b1])),
                (b'i', 4) => f64::from(i32::from_le_bytes([b0, b1, b2, b3])),
                (b'i', _) => i64::from_le_bytes(word) as f64,
                _ => bits as f64,
            }
        };
        Ok(bytes.chunks_exact(size).map(number).collect())
    }
}

/// An array of numbers, the last index running fastest.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Numbers {
    pub(super) shape: Vec<usize>,
    pub(super) values: Vec<f64>,
}

impl Numbers {
    pub(super) fn decode(
        kind: &Type,
        shape: Vec<usize>,
        fortran: bool,
        bytes: &[u8],
    ) -> Result<Self, String> {
        let count = shape
            .iter()
            .try_fold(1usize, |n, &side| n.checked_mul(side));
        let count = count.ok_or_else(|| format!("it has an array of shape {shape:?}"))?;
        let mut values = kind.numbers(bytes, count)?;
        if fortran && shape.len() > 1 {
            let [rows, columns] = shape[..] else {
                return Err(
                    "it has an array of more than two dimensions in Fortran's order".to_owned(),
                );
            };
            values = (0..count)
                .map(|i| values[i % columns * rows + i / columns])
                .collect();
        }
        Ok(Self { shape, values })
    }

    /// Rows of equal length: of a table, or one row where there is a single dimension.
    pub(super) fn rows(&self) -> Option<Vec<Vec<f64>>> {
        match self.shape[..] {
            [_] => Some(vec![self.values.clone()]),
            [_, columns] if columns > 0 => Some(
                self.values
                    .chunks_exact(columns)
                    .map(<[f64]>::to_vec)
                    .collect(),
            ),
            _ => None,
        }
    }
}

/// What a file holds.
#[derive(Debug)]
pub(super) enum Content {
    Numbers(Numbers),
    /// A pickle's values, and which of them is the whole.
    Objects(Heap, Id),
}

/// Reads the bytes of a file. Errors are half a sentence: what is wrong with it.
pub(super) fn read(bytes: &[u8]) -> Result<Content, String> {
    let cut = || "it is cut short".to_owned();
    let rest = bytes
        .strip_prefix(MAGIC)
        .ok_or("it is no .npy file of numpy")?;
    let (version, rest) = rest.split_at_checked(2).ok_or_else(cut)?;
    let (length, rest) = if version[0] == 1 {
        let (length, rest) = rest.split_first_chunk::<2>().ok_or_else(cut)?;
        (usize::from(u16::from_le_bytes(*length)), rest)
    } else {
        let (length, rest) = rest.split_first_chunk::<4>().ok_or_else(cut)?;
        (
            usize::try_from(u32::from_le_bytes(*length)).unwrap_or(usize::MAX),
            rest,
        )
    };
    let (header, body) = rest.split_at_checked(length).ok_or_else(cut)?;
    let header = String::from_utf8_lossy(header);
    let kind = Type::parse(&described(&header)?)?;
    if kind == Type::Object {
        let (heap, whole) =
            load(body).map_err(|problem| format!("its pickle cannot be read: {problem}"))?;
        return Ok(Content::Objects(heap, whole));
    }
    let fortran = field(&header, "fortran_order")?.starts_with("True");
    let shape = field(&header, "shape")?
        .trim_start()
        .strip_prefix('(')
        .and_then(|rest| rest.split_once(')'));
    let shape = shape.ok_or_else(|| "its header has no shape".to_owned())?.0;
    let sides = shape
        .split(',')
        .map(str::trim)
        .filter(|side| !side.is_empty());
    let sides: Option<Vec<usize>> = sides.map(|side| side.parse().ok()).collect();
    let shape = sides.ok_or_else(|| format!("its header has the shape ({shape})"))?;
    Ok(Content::Numbers(Numbers::decode(
        &kind, shape, fortran, body,
    )?))
}

/// What follows a key of the header.
fn field<'a>(header: &'a str, key: &str) -> Result<&'a str, String> {
    let quoted = format!("'{key}':");
    let place = header
        .find(&quoted)
        .ok_or_else(|| format!("its header has no {key}"))?;
    Ok(header[place + quoted.len()..].trim_start())
}

fn described(header: &str) -> Result<String, String> {
    let text = field(header, "descr")?;
    let quote = text.chars().next().filter(|c| matches!(c, '\'' | '"'));
    let quote = quote.ok_or("its items are records; numbers or dictionaries are needed")?;
    let rest = &text[1..];
    Ok(rest[..rest.find(quote).ok_or("its header is damaged")?].to_owned())
}

/// A file of the given type and shape around its content.
pub(super) fn with_header(descr: &str, shape: &str, body: &[u8]) -> Vec<u8> {
    let mut header = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': {shape}, }}");
    let before = MAGIC.len() + 4;
    while !(before + header.len() + 1).is_multiple_of(64) {
        header.push(' ');
    }
    header.push('\n');
    let mut bytes = MAGIC.to_vec();
    bytes.extend([1, 0]);
    bytes.extend(
        u16::try_from(header.len())
            .unwrap_or(u16::MAX)
            .to_le_bytes(),
    );
    bytes.extend(header.as_bytes());
    bytes.extend(body);
    bytes
}

/// A table of numbers as a file.
pub(super) fn table(rows: &[Vec<f64>]) -> Vec<u8> {
    let columns = rows.first().map_or(0, Vec::len);
    let body: Vec<u8> = rows
        .iter()
        .flatten()
        .flat_map(|value| value.to_le_bytes())
        .collect();
    with_header("<f8", &format!("({}, {columns})", rows.len()), &body)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_come_back() {
        let rows = vec![vec![0.1, -2.0, f64::MIN_POSITIVE], vec![1e300, 4.0, 5.0]];
        let Content::Numbers(numbers) = read(&table(&rows)).unwrap() else {
            panic!("a table");
        };
        assert_eq!(numbers.rows().unwrap(), rows);
    }

    #[test]
    fn other_types_and_orders_are_read() {
        let header = |descr: &str, order: &str, body: &[u8]| {
            let bytes = with_header(descr, "(2, 3)", body);
            let text = String::from_utf8_lossy(&bytes[10..74]).replace("False", order);
            let mut bytes = bytes[..10].to_vec();
            bytes.extend(text.as_bytes());
            // The header ends where its length says.
            bytes[8] = 64;
            bytes[9] = 0;
            bytes.extend(body);
            read(&bytes)
        };
        let big: Vec<u8> = (1..7i16).flat_map(i16::to_be_bytes).collect();
        let Ok(Content::Numbers(rows)) = header(">i2", "False", &big) else {
            panic!("numbers");
        };
        assert_eq!(rows.rows().unwrap(), [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]);
        let Ok(Content::Numbers(rows)) = header("|u1", "True ", &[1, 4, 2, 5, 3, 6]) else {
            panic!("numbers");
        };
        assert_eq!(rows.rows().unwrap(), [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]);
    }

    #[test]
    fn damaged_files_are_refused() {
        let good = table(&[vec![1.0, 2.0]]);
        for length in [0, 5, 7, 9, 40, good.len() - 1] {
            assert!(read(&good[..length]).is_err(), "{length}");
        }
        for (descr, shape) in [
            ("<f8", "(99999999999, 99999999999)"),
            ("<c16", "(1,)"),
            ("<U9", "(1,)"),
        ] {
            assert!(read(&with_header(descr, shape, &[0; 16])).is_err());
        }
    }

    #[test]
    fn a_pickle_that_calls_anything_is_refused() {
        let of = |pickle: &[u8]| read(&with_header("|O", "()", pickle)).unwrap_err();
        for call in [
            &b"\x80\x03cos\nsystem\nX\x02\x00\x00\x00ls\x85R."[..],
            b"\x80\x04\x8c\x02os\x94\x8c\x06system\x94\x93\x94\x8c\x02ls\x85R.",
        ] {
            let said = of(call);
            assert!(
                said.contains("it calls os.system") && said.contains("nothing"),
                "{said}"
            );
        }
        assert!(of(b"\x80\x03cbuiltins\neval\nX\x01\x00\x00\x001\x85R.").contains("builtins.eval"));
        for (pickle, words) in [
            (&b"\x80\x03"[..], "cut short"),
            (b".", "not there"),
            (b"(K\x01", "cut short"),
            (b"e.", "mark"),
            (b"K\x01(a.", "not there"),
            (b"h\x07.", "not there"),
            (b"K\x01r\xff\xff\xff\x7f.", "gaps"),
            (b"X\xff\xff\xff\x7fabc.", "cut short"),
            (b"K\x01K\x02b.", "other than an array"),
            (b"P1\n.", "instruction"),
            (b"]K\x01]bK\x02.", "other than"),
        ] {
            let said = of(pickle);
            assert!(said.contains(words), "{pickle:?}: {said}");
        }
    }
}
