//! numpy's `.npy` files (NEP 1): a header in Python notation, then numbers or a pickle.

use std::borrow::Cow;

use super::array::{Numbers, Type};
#[cfg(feature = "cli")]
use super::pickle::{Heap, Id, load};

const MAGIC: &[u8] = b"\x93NUMPY";

/// Content of a file.
#[cfg(feature = "cli")]
#[derive(Debug)]
pub(crate) enum Content {
    Numbers(Numbers),
    /// The values of a pickle, and the number of the top-level value.
    Objects(Heap, Id),
}

/// Reads the bytes of a file of numbers or a pickle.
#[cfg(feature = "cli")]
pub(crate) fn read(bytes: &[u8]) -> Result<Content, String> {
    let file = File::open(bytes)?;
    let kind = file.kind()?;
    if kind == Type::Object {
        let (heap, whole) =
            load(file.body).map_err(|problem| format!("its pickle cannot be read: {problem}"))?;
        return Ok(Content::Objects(heap, whole));
    }
    file.numbers(kind).map(Content::Numbers)
}

/// Reads the bytes of a file of numbers; `None` if its items are not numbers.
pub(crate) fn numbers(bytes: &[u8]) -> Result<Option<Numbers>, String> {
    let file = File::open(bytes)?;
    file.field("descr")?;
    match file.kind() {
        Ok(kind @ Type::Number { .. }) => file.numbers(kind).map(Some),
        _ => Ok(None),
    }
}

/// A file with its header not yet parsed.
struct File<'a> {
    header: Cow<'a, str>,
    body: &'a [u8],
}

impl<'a> File<'a> {
    fn open(bytes: &'a [u8]) -> Result<Self, String> {
        let cut = || "it is cut short".to_owned();
        let rest = bytes
            .strip_prefix(MAGIC)
            .ok_or("it is not a .npy file of numpy")?;
        let (version, rest) = rest.split_at_checked(2).ok_or_else(cut)?;
        let (length, rest) = if version[0] == 1 {
            let (length, rest) = rest.split_first_chunk::<2>().ok_or_else(cut)?;
            (usize::from(u16::from_le_bytes(*length)), rest)
        } else {
            let (length, rest) = rest.split_first_chunk::<4>().ok_or_else(cut)?;
            let length = u32::from_le_bytes(*length);
            (usize::try_from(length).unwrap_or(usize::MAX), rest)
        };
        let (header, body) = rest.split_at_checked(length).ok_or_else(cut)?;
        let header = String::from_utf8_lossy(header);
        Ok(Self { header, body })
    }

    /// The text after a key of the header.
    fn field(&self, key: &str) -> Result<&str, String> {
        let quoted = format!("'{key}':");
        let (_, rest) =
            (self.header.split_once(&quoted)).ok_or_else(|| format!("its header has no {key}"))?;
        Ok(rest.trim_start())
    }

    fn kind(&self) -> Result<Type, String> {
        let text = self.field("descr")?;
        let quote = text.chars().next().filter(|c| matches!(c, '\'' | '"'));
        let quote = quote.ok_or("its items are records; numbers or dictionaries are needed")?;
        let (code, _) = (text[1..].split_once(quote)).ok_or("its header is damaged")?;
        Type::parse(code)
    }

    fn numbers(&self, kind: Type) -> Result<Numbers, String> {
        let fortran = self.field("fortran_order")?.starts_with("True");
        let shape = self.field("shape")?.strip_prefix('(');
        let shape = shape.and_then(|rest| rest.split_once(')'));
        let shape = shape.ok_or("its header has no shape")?.0;
        let sides = shape.split(',').map(str::trim);
        let sides = sides.filter(|side| !side.is_empty());
        let sides: Option<Vec<usize>> = sides.map(|side| side.parse().ok()).collect();
        let shape = sides.ok_or_else(|| format!("its header has the shape ({shape})"))?;
        Numbers::decode(kind, shape, fortran, self.body)
    }
}

/// The bytes of a file with the given type, shape and content.
pub(crate) fn with_header(descr: &str, shape: &str, body: &[u8]) -> Vec<u8> {
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

/// The bytes of a file with a table of numbers.
pub(crate) fn table(rows: &[Vec<f64>]) -> Vec<u8> {
    let columns = rows.first().map_or(0, Vec::len);
    let body: Vec<u8> = rows
        .iter()
        .flatten()
        .flat_map(|value| value.to_le_bytes())
        .collect();
    with_header("<f8", &format!("({}, {columns})", rows.len()), &body)
}

#[cfg(all(test, feature = "cli"))]
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
    fn a_pickle_that_calls_anything_is_refused() {
        let of = |pickle: &[u8]| read(&with_header("|O", "()", pickle)).unwrap_err();
        for call in [
            &b"\x80\x03cos\nsystem\nX\x02\x00\x00\x00ls\x85R."[..],
            b"\x80\x04\x8c\x02os\x94\x8c\x06system\x94\x93\x94\x8c\x02ls\x85R.",
        ] {
            let said = of(call);
            assert!(
                said.contains("it calls os.system") && said.contains("no code"),
                "{said}"
            );
        }
        assert!(of(b"\x80\x03cbuiltins\neval\nX\x01\x00\x00\x001\x85R.").contains("builtins.eval"));
        for (pickle, words) in [
            (&b"\x80\x03"[..], "cut short"),
            (b".", "stack"),
            (b"(K\x01", "cut short"),
            (b"e.", "mark"),
            (b"K\x01(a.", "stack"),
            (b"h\x07.", "does not exist"),
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
