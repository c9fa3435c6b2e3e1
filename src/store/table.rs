//! Conversion of Parquet columns to Rust values. This module knows nothing about grasps.
//!
//! It accepts columns written by pandas, polars or `DuckDB`: 32-bit floats, other integer widths, large or
//! dictionary-encoded strings, lists of fixed or variable length. A number that is not finite is an error.

use std::collections::BTreeMap;
use std::fmt::Display;
use std::fs::File;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use arrow_array::cast::AsArray;
use arrow_array::types::{
    ArrowPrimitiveType, Float32Type, Float64Type, Int8Type, Int16Type, Int32Type, Int64Type,
    UInt8Type, UInt16Type, UInt32Type, UInt64Type,
};
use arrow_array::{Array, ArrayRef, OffsetSizeTrait, RecordBatch};
use arrow_schema::{DataType, Schema};
use bytes::Bytes;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use parquet::basic::CompressionCodec;
use parquet::file::metadata::{ColumnChunkMetaData, FileMetaData, RowGroupMetaData};
use parquet::file::reader::{FileReader, SerializedFileReader};
use serde_json::Value;

use super::columns::{ATTRIBUTES, KEY};
use super::error::{Fault, StoreError};
use super::sum::{self, Seal};
use crate::caught::caught;

/// A table in memory.
pub(super) struct Table {
    path: PathBuf,
    schema: Arc<Schema>,
    batches: Vec<RecordBatch>,
    /// The metadata under [`KEY`], or the copy of them that another program kept.
    pub(super) metadata: Option<String>,
    /// Whether the checksum vouches for the content.
    pub(super) sealed: bool,
    pub(super) rows: usize,
}

impl Table {
    pub(super) fn read(path: &Path) -> Result<Self, StoreError> {
        let bytes = std::fs::read(path).map_err(StoreError::io("read", path))?;
        Self::of_bytes(path, bytes)
    }

    pub(super) fn of_bytes(path: &Path, bytes: Vec<u8>) -> Result<Self, StoreError> {
        // The parquet crate panics on some damaged pages; this becomes an error about a damaged file.
        caught(|| Self::decode(path, &bytes.into()))
            .unwrap_or_else(|| Err(damaged(path, &"its pages contradict its footer")))
    }

    /// Whether the footer of a Parquet file has metadata of this program. Only the footer is read.
    pub(super) fn describes_itself(path: &Path) -> bool {
        let holds = || {
            let file = File::open(path).ok()?;
            let reader = SerializedFileReader::new(file).ok()?;
            let pairs = reader.metadata().file_metadata().key_value_metadata()?;
            pairs.iter().find(|pair| pair.key == KEY).map(|_| ())
        };
        caught(holds).flatten().is_some()
    }

    fn decode(path: &Path, bytes: &Bytes) -> Result<Self, StoreError> {
        let builder = ParquetRecordBatchReaderBuilder::try_new(bytes.clone())
            .map_err(|error| damaged(path, &error))?;
        let seal = sum::seal(bytes, builder.metadata().file_metadata());
        if seal == Seal::Broken {
            return Err(StoreError::Altered(path.to_path_buf()));
        }
        let chunks = builder
            .metadata()
            .row_groups()
            .iter()
            .flat_map(RowGroupMetaData::columns);
        for codec in chunks.map(ColumnChunkMetaData::compression_codec) {
            if matches!(codec, CompressionCodec::LZO) {
                let codec = format!("{codec:?}");
                return Err(StoreError::Compression {
                    path: path.to_path_buf(),
                    codec,
                });
            }
        }
        let schema = Arc::clone(builder.schema());
        let metadata = metadata(builder.metadata().file_metadata(), &schema);
        let reader = builder
            .with_batch_size(1 << 16)
            .build()
            .map_err(|error| damaged(path, &error))?;
        let batches: Vec<_> = reader
            .collect::<Result<_, _>>()
            .map_err(|error| damaged(path, &error))?;
        let rows = batches.iter().map(RecordBatch::num_rows).sum();
        Ok(Self {
            path: path.to_path_buf(),
            schema,
            batches,
            metadata,
            sealed: seal == Seal::Whole,
            rows,
        })
    }

    pub(super) fn has(&self, name: &str) -> bool {
        self.schema.column_with_name(name).is_some()
    }

    /// Names of all columns, in file order.
    pub(super) fn names(&self) -> impl Iterator<Item = &str> {
        self.schema
            .fields()
            .iter()
            .map(|field| field.name().as_str())
    }

    /// A required column without nulls.
    pub(super) fn required<T>(&self, name: &str, kind: &Kind<T>) -> Result<Vec<T>, StoreError> {
        if !self.has(name) {
            let (path, column) = (self.path.clone(), name.to_owned());
            return Err(StoreError::MissingColumn {
                path,
                column,
                expected: kind.expected,
            });
        }
        let missing = |row| {
            self.fault(
                row,
                Fault::Missing {
                    column: name.to_owned(),
                },
            )
        };
        let values = self.optional(name, kind)?.into_iter().enumerate();
        values
            .map(|(row, value)| value.ok_or_else(|| missing(row)))
            .collect()
    }

    /// A column that may be absent or have nulls.
    pub(super) fn optional<T>(
        &self,
        name: &str,
        kind: &Kind<T>,
    ) -> Result<Vec<Option<T>>, StoreError> {
        let mut values = Vec::with_capacity(self.rows);
        for batch in &self.batches {
            let Some(array) = batch.column_by_name(name) else {
                values.extend((0..batch.num_rows()).map(|_| None));
                continue;
            };
            let before = values.len();
            values.extend((kind.convert)(array).map_err(|misfit| match misfit {
                Misfit::Type => StoreError::ColumnType {
                    path: self.path.clone(),
                    column: name.to_owned(),
                    expected: kind.expected,
                    found: content(array.data_type()),
                },
                Misfit::Empty { row } => self.fault(
                    before + row,
                    Fault::Missing {
                        column: name.to_owned(),
                    },
                ),
                Misfit::NotFinite { row, value } => self.fault(
                    before + row,
                    Fault::NotFinite {
                        column: name.to_owned(),
                        value,
                    },
                ),
                Misfit::NotWhole {
                    row,
                    value,
                    largest,
                } => self.fault(
                    before + row,
                    Fault::NotWhole {
                        column: name.to_owned(),
                        value,
                        largest,
                    },
                ),
            })?);
        }
        Ok(values)
    }

    pub(super) fn fault(&self, row: usize, fault: Fault) -> StoreError {
        StoreError::Row {
            path: self.path.clone(),
            row,
            fault,
        }
    }
}

/// The metadata of this program: in the footer as it wrote them; in Arrow's copy of the schema, which pyarrow keeps; or among
/// the attributes of a data frame, which pandas keeps.
fn metadata(footer: &FileMetaData, schema: &Schema) -> Option<String> {
    let in_footer = |key: &str| {
        let mut pairs = footer.key_value_metadata().into_iter().flatten();
        pairs
            .find(|pair| pair.key == key)
            .and_then(|pair| pair.value.clone())
    };
    let in_schema = |key: &str| schema.metadata().get(key).cloned();
    let among = |attributes: String| {
        let attributes: BTreeMap<String, Value> = serde_json::from_str(&attributes).ok()?;
        attributes.get(KEY).map(ToString::to_string)
    };
    in_footer(KEY)
        .or_else(|| in_schema(KEY))
        .or_else(|| in_footer(ATTRIBUTES).and_then(among))
        .or_else(|| in_schema(ATTRIBUTES).and_then(among))
}

fn damaged(path: &Path, reason: &dyn Display) -> StoreError {
    StoreError::NotParquet {
        path: path.to_path_buf(),
        reason: reason
            .to_string()
            .trim_start_matches("Parquet error: ")
            .to_owned(),
    }
}

/// What a column of this type holds, in words.
fn content(kind: &DataType) -> String {
    let lists = |element: &DataType| format!("lists of {}", content(element));
    match kind {
        DataType::Utf8 | DataType::LargeUtf8 | DataType::Utf8View => "text".to_owned(),
        DataType::Dictionary(_, values) => content(values),
        DataType::Boolean => "true or false".to_owned(),
        kind if kind.is_integer() => "whole numbers".to_owned(),
        kind if kind.is_floating() => "numbers".to_owned(),
        DataType::List(element)
        | DataType::LargeList(element)
        | DataType::FixedSizeList(element, _) => lists(element.data_type()),
        other => format!("values of type {other}"),
    }
}

/// A kind of column: its name in errors and its conversion.
pub(super) struct Kind<T> {
    expected: &'static str,
    convert: fn(&ArrayRef) -> Result<Vec<Option<T>>, Misfit>,
}

pub(super) const FLOAT: Kind<f64> = Kind {
    expected: "numbers",
    convert: floats,
};
pub(super) const WHOLE: Kind<u64> = Kind {
    expected: "whole numbers",
    convert: |array| wholes(array, u64::MAX),
};
pub(super) const TEXT: Kind<String> = Kind {
    expected: "text",
    convert: texts,
};
pub(super) const FLAG: Kind<bool> = Kind {
    expected: "true or false",
    convert: flags,
};
pub(super) const VECTOR: Kind<Vec<f64>> = Kind {
    expected: "lists of numbers",
    convert: |array| lists(array, &floats),
};
pub(super) const IDS: Kind<Vec<u64>> = Kind {
    expected: "lists of whole numbers",
    convert: |array| lists(array, &|values| wholes(values, u64::MAX)),
};
pub(super) const INDICES: Kind<Vec<u32>> = Kind {
    expected: "lists of whole numbers",
    convert: indices,
};
pub(super) const TEXTS: Kind<Vec<String>> = Kind {
    expected: "lists of text",
    convert: |array| lists(array, &texts),
};

/// Reasons why a column cannot be converted.
enum Misfit {
    Type,
    Empty {
        row: usize,
    },
    NotFinite {
        row: usize,
        value: f64,
    },
    NotWhole {
        row: usize,
        value: i128,
        largest: u64,
    },
}

impl Misfit {
    fn row(&mut self) -> Option<&mut usize> {
        match self {
            Self::Type => None,
            Self::Empty { row } | Self::NotFinite { row, .. } | Self::NotWhole { row, .. } => {
                Some(row)
            }
        }
    }
}

type Converted<T> = Result<Vec<Option<T>>, Misfit>;

fn primitives<T: ArrowPrimitiveType, U>(
    array: &ArrayRef,
    convert: impl Fn(T::Native) -> U,
) -> Vec<Option<U>> {
    array
        .as_primitive::<T>()
        .iter()
        .map(|value| value.map(&convert))
        .collect()
}

fn integers(array: &ArrayRef) -> Option<Vec<Option<i128>>> {
    Some(match array.data_type() {
        DataType::Int8 => primitives::<Int8Type, _>(array, i128::from),
        DataType::Int16 => primitives::<Int16Type, _>(array, i128::from),
        DataType::Int32 => primitives::<Int32Type, _>(array, i128::from),
        DataType::Int64 => primitives::<Int64Type, _>(array, i128::from),
        DataType::UInt8 => primitives::<UInt8Type, _>(array, i128::from),
        DataType::UInt16 => primitives::<UInt16Type, _>(array, i128::from),
        DataType::UInt32 => primitives::<UInt32Type, _>(array, i128::from),
        DataType::UInt64 => primitives::<UInt64Type, _>(array, i128::from),
        // pandas writes a column of nulls only with this type.
        DataType::Null => vec![None; array.len()],
        _ => return None,
    })
}

fn wholes(array: &ArrayRef, largest: u64) -> Converted<u64> {
    let values = integers(array).ok_or(Misfit::Type)?.into_iter().enumerate();
    let whole = |row, value| {
        u64::try_from(value)
            .ok()
            .filter(|value| *value <= largest)
            .ok_or(Misfit::NotWhole {
                row,
                value,
                largest,
            })
    };
    values
        .map(|(row, value)| value.map(|value| whole(row, value)).transpose())
        .collect()
}

fn floats(array: &ArrayRef) -> Converted<f64> {
    let values = match array.data_type() {
        DataType::Float64 => primitives::<Float64Type, _>(array, |value| value),
        DataType::Float32 => primitives::<Float32Type, _>(array, f64::from),
        _ => integers(array)
            .ok_or(Misfit::Type)?
            .into_iter()
            .map(|value| value.map(|value| value as f64))
            .collect(),
    };
    match values
        .iter()
        .position(|value| value.is_some_and(|value| !value.is_finite()))
    {
        Some(row) => Err(Misfit::NotFinite {
            row,
            value: values[row].unwrap_or(f64::NAN),
        }),
        None => Ok(values),
    }
}

fn texts(array: &ArrayRef) -> Converted<String> {
    Ok(match array.data_type() {
        DataType::Utf8 => array
            .as_string::<i32>()
            .iter()
            .map(|text| text.map(str::to_owned))
            .collect(),
        DataType::LargeUtf8 => array
            .as_string::<i64>()
            .iter()
            .map(|text| text.map(str::to_owned))
            .collect(),
        DataType::Utf8View => array
            .as_string_view()
            .iter()
            .map(|text| text.map(str::to_owned))
            .collect(),
        DataType::Null => vec![None; array.len()],
        DataType::Dictionary(..) => {
            let dictionary = array.as_any_dictionary();
            let words = texts(dictionary.values())?;
            if words.is_empty() {
                return Ok(vec![None; array.len()]);
            }
            let keys = dictionary.normalized_keys().into_iter().enumerate();
            keys.map(|(row, key)| {
                if array.is_null(row) {
                    None
                } else {
                    words[key].clone()
                }
            })
            .collect()
        }
        _ => return Err(Misfit::Type),
    })
}

fn flags(array: &ArrayRef) -> Converted<bool> {
    match array.data_type() {
        DataType::Boolean => Ok(array.as_boolean().iter().collect()),
        DataType::Null => Ok(vec![None; array.len()]),
        _ => Err(Misfit::Type),
    }
}

fn indices(array: &ArrayRef) -> Converted<Vec<u32>> {
    let narrow = |value| u32::try_from(value).expect("wholes keeps to the largest value given");
    let rows = lists(array, &|values| wholes(values, u64::from(u32::MAX)))?;
    Ok(rows
        .into_iter()
        .map(|row| row.map(|row| row.into_iter().map(narrow).collect()))
        .collect())
}

/// Converts all elements at once, then splits them into rows.
fn lists<T: Clone>(
    array: &ArrayRef,
    convert: &dyn Fn(&ArrayRef) -> Converted<T>,
) -> Converted<Vec<T>> {
    let (elements, rows): (ArrayRef, Vec<Range<usize>>) = match array.data_type() {
        DataType::List(_) => {
            let list = array.as_list::<i32>();
            (Arc::clone(list.values()), ranges(list.value_offsets()))
        }
        DataType::LargeList(_) => {
            let list = array.as_list::<i64>();
            (Arc::clone(list.values()), ranges(list.value_offsets()))
        }
        DataType::FixedSizeList(..) => {
            let list = array.as_fixed_size_list();
            let start = |row| list.value_offset_at(row);
            (
                Arc::clone(list.values()),
                (0..list.len())
                    .map(|row| start(row)..start(row + 1))
                    .collect(),
            )
        }
        DataType::Null => return Ok(vec![None; array.len()]),
        _ => return Err(Misfit::Type),
    };
    // A fault is found at an element, but errors refer to rows.
    let row_of = |element: usize| {
        rows.iter()
            .enumerate()
            .position(|(row, range)| range.contains(&element) && array.is_valid(row))
    };
    let elements = convert(&elements).map_err(|mut misfit| {
        if let Some(row) = misfit.row() {
            *row = row_of(*row).unwrap_or_default();
        }
        misfit
    })?;
    let mut converted = Vec::with_capacity(rows.len());
    for (row, range) in rows.into_iter().enumerate() {
        let whole: Option<Vec<T>> = elements[range].iter().cloned().collect();
        converted.push(if array.is_valid(row) {
            Some(whole.ok_or(Misfit::Empty { row })?)
        } else {
            None
        });
    }
    Ok(converted)
}

fn ranges<O: OffsetSizeTrait>(offsets: &[O]) -> Vec<Range<usize>> {
    offsets
        .windows(2)
        .map(|ends| ends[0].as_usize()..ends[1].as_usize())
        .collect()
}
