//! The data of a page: a header (JSON) and arrays of numbers behind it, deflated together and written in base64.
//!
//! In the header an array stands as an object with the key `packed`, see `web/data.js`, which reads this.

use std::collections::BTreeMap;
use std::io::Write;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::ZlibEncoder;
use serde_json::{Value, json};

/// Alignment of arrays, bytes.
const ALIGNMENT: usize = 8;
/// Number of steps between the least and the greatest value of a column of a table.
const STEPS: f64 = 65535.0;

/// The arrays of a page.
#[derive(Debug, Default)]
pub(super) struct Pack {
    bytes: Vec<u8>,
}

impl Pack {
    fn array(&mut self, kind: &str, count: usize, bytes: impl Iterator<Item = u8>) -> Value {
        self.bytes
            .resize(self.bytes.len().next_multiple_of(ALIGNMENT), 0);
        let start = self.bytes.len();
        self.bytes.extend(bytes);
        json!({ "packed": kind, "start": start, "count": count })
    }

    /// Numbers of double precision.
    pub(super) fn doubles(&mut self, values: &[f64]) -> Value {
        let bytes = values.iter().flat_map(|value| value.to_le_bytes());
        self.array("f8", values.len(), bytes)
    }

    /// Numbers of single precision.
    #[expect(
        clippy::cast_possible_truncation,
        reason = "single precision is what is asked for"
    )]
    pub(super) fn floats(&mut self, values: &[f64]) -> Value {
        let bytes = values
            .iter()
            .flat_map(|value| (*value as f32).to_le_bytes());
        self.array("f4", values.len(), bytes)
    }

    /// Numbers that may be unknown, which the page reads as NaN.
    pub(super) fn known_floats(&mut self, values: impl IntoIterator<Item = Option<f64>>) -> Value {
        let values: Vec<f64> = values
            .into_iter()
            .map(|value| value.unwrap_or(f64::NAN))
            .collect();
        self.floats(&values)
    }

    /// Whole numbers below 2³².
    pub(super) fn wholes(&mut self, values: impl IntoIterator<Item = usize>) -> Value {
        let narrow = |value| u32::try_from(value).unwrap_or(u32::MAX);
        let values: Vec<u32> = values.into_iter().map(narrow).collect();
        let bytes = values.iter().flat_map(|value| value.to_le_bytes());
        self.array("u4", values.len(), bytes)
    }

    /// Whole numbers below 2⁸.
    pub(super) fn bytes(&mut self, values: impl IntoIterator<Item = u8>) -> Value {
        let values: Vec<u8> = values.into_iter().collect();
        self.array("u1", values.len(), values.into_iter())
    }

    /// A table of `columns` numbers a row, each column in 2¹⁶ steps from its least to its greatest value. It is stored
    /// column by column, as differences from row to row, which deflate to half the size if rows follow a path.
    ///
    /// # Panics
    /// If there is not a whole number of rows.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "between 0 and the number of steps"
    )]
    pub(super) fn table(&mut self, columns: usize, values: &[f64]) -> Value {
        let rows = values.len() / columns.max(1);
        assert_eq!(rows * columns, values.len(), "whole rows");
        let column = |column: usize| values.iter().skip(column).step_by(columns);
        let (mut low, mut step) = (Vec::new(), Vec::new());
        let mut differences: Vec<u16> = Vec::with_capacity(values.len());
        for number in 0..columns {
            let least = column(number).copied().fold(f64::INFINITY, f64::min);
            let most = column(number).copied().fold(f64::NEG_INFINITY, f64::max);
            let width = if most > least {
                (most - least) / STEPS
            } else {
                1.0
            };
            let mut before = 0_u16;
            for value in column(number) {
                let here = ((value - least) / width).round().clamp(0.0, STEPS) as u16;
                differences.push(here.wrapping_sub(before));
                before = here;
            }
            low.push(if least.is_finite() { least } else { 0.0 });
            step.push(width);
        }
        let bytes = differences.iter().flat_map(|value| value.to_le_bytes());
        let mut table = self.array("table", rows, bytes);
        table["low"] = json!(low);
        table["step"] = json!(step);
        table
    }

    /// The header and the arrays, deflated, in base64.
    pub(super) fn deflated(&self, header: &Value) -> String {
        let mut text = header.to_string().into_bytes();
        text.resize((text.len() + 4).next_multiple_of(ALIGNMENT) - 4, b' ');
        let length = u32::try_from(text.len()).unwrap_or(u32::MAX);
        let mut encoder = ZlibEncoder::new(Vec::new(), Compression::best());
        let mut write = |bytes: &[u8]| encoder.write_all(bytes);
        let written = (write(&length.to_le_bytes()))
            .and_then(|()| write(&text))
            .and_then(|()| write(&self.bytes))
            .and_then(|()| encoder.finish());
        STANDARD.encode(written.expect("memory can be written"))
    }
}

/// Texts that many rows share: each is stored once.
#[derive(Debug, Default)]
pub(super) struct Texts {
    known: BTreeMap<String, usize>,
    list: Vec<String>,
    rows: Vec<usize>,
}

impl Texts {
    /// Appends the text of a row.
    pub(super) fn push(&mut self, text: &str) {
        let next = self.list.len();
        let number = *self.known.entry(text.to_owned()).or_insert(next);
        if number == next {
            self.list.push(text.to_owned());
        }
        self.rows.push(number);
    }

    /// The texts, and the number of the text of each row.
    pub(super) fn packed(self, pack: &mut Pack) -> Value {
        json!({ "texts": self.list, "of": pack.wholes(self.rows) })
    }
}

impl<'a> FromIterator<&'a str> for Texts {
    fn from_iter<T: IntoIterator<Item = &'a str>>(rows: T) -> Self {
        let mut texts = Self::default();
        rows.into_iter().for_each(|text| texts.push(text));
        texts
    }
}

#[cfg(test)]
mod tests {
    use std::io::Read;

    use flate2::read::ZlibDecoder;

    use super::*;

    #[test]
    fn a_table_keeps_each_column_to_a_step() {
        let values = [0.0, -5.0, 1.0, 5.0, 0.25, 5.0];
        let mut pack = Pack::default();
        let table = pack.table(2, &values);
        assert_eq!(
            (table["count"].as_u64(), table["packed"].as_str()),
            (Some(3), Some("table"))
        );
        let steps: Vec<u16> = (pack.bytes.chunks_exact(2))
            .map(|pair| u16::from_le_bytes([pair[0], pair[1]]))
            .collect();
        for column in 0..2 {
            let mut sum = 0_u16;
            for row in 0..3 {
                sum = sum.wrapping_add(steps[3 * column + row]);
                let (low, step) = (&table["low"][column], &table["step"][column]);
                let value = low.as_f64().unwrap() + f64::from(sum) * step.as_f64().unwrap();
                assert!((value - values[2 * row + column]).abs() <= step.as_f64().unwrap());
            }
        }
    }

    #[test]
    fn what_is_packed_is_read_again() {
        let mut pack = Pack::default();
        let header =
            json!({ "a": pack.bytes([1, 2, 3]), "b": pack.doubles(&[0.5]), "c": "é</script>" });
        assert_eq!(header["b"]["start"], 8);
        let bytes = STANDARD.decode(pack.deflated(&header)).unwrap();
        let mut plain = Vec::new();
        ZlibDecoder::new(&bytes[..])
            .read_to_end(&mut plain)
            .unwrap();
        let length = u32::from_le_bytes(plain[..4].try_into().unwrap()) as usize;
        assert_eq!((4 + length) % ALIGNMENT, 0);
        let read: Value = serde_json::from_slice(&plain[4..4 + length]).unwrap();
        assert_eq!(read, header);
        assert_eq!(plain[4 + length + 8..], 0.5_f64.to_le_bytes());
    }

    #[test]
    fn equal_texts_are_stored_once() {
        let texts: Texts = ["b", "a", "b"].into_iter().collect();
        assert_eq!(
            (texts.list, texts.rows),
            (vec!["b".to_owned(), "a".to_owned()], vec![0, 1, 0])
        );
    }
}
