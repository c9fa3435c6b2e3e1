//! Conversion of Rust values to Parquet columns. Equal content gives equal bytes. This module knows nothing about grasps.

use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

use arrow_array::builder::{
    FixedSizeListBuilder, Float64Builder, ListBuilder, PrimitiveBuilder, StringBuilder,
};
use arrow_array::types::{ArrowPrimitiveType, Float64Type, UInt32Type, UInt64Type};
use arrow_array::{ArrayRef, BooleanArray, Float64Array, RecordBatch, StringArray, UInt64Array};
use arrow_schema::{DataType, Field, FieldRef, Schema};
use parquet::arrow::ArrowWriter;
use parquet::basic::Compression;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;

use super::error::{Fault, StoreError};
use super::sum;

/// Parquet metadata key for the metadata of this program.
pub(super) const KEY: &str = "landscape";

/// Key under which pandas keeps the attributes of a data frame, a JSON object, in Arrow's copy of the schema.
pub(super) const ATTRIBUTES: &str = "PANDAS_ATTRS";

/// A table to be written.
#[derive(Default)]
pub(super) struct Columns {
    fields: Vec<Field>,
    arrays: Vec<ArrayRef>,
    fault: Option<(usize, Fault)>,
}

impl Columns {
    pub(super) fn wholes(&mut self, name: &str, values: impl Iterator<Item = u64>) {
        self.push(name, false, Arc::new(UInt64Array::from_iter_values(values)));
    }

    pub(super) fn floats(&mut self, name: &str, values: impl Iterator<Item = f64>) {
        let values: Vec<f64> = values.collect();
        self.watch(name, values.iter().copied().map(Some));
        self.push(name, false, Arc::new(Float64Array::from(values)));
    }

    pub(super) fn optional_floats(
        &mut self,
        name: &str,
        values: impl Iterator<Item = Option<f64>>,
    ) {
        let values: Vec<Option<f64>> = values.collect();
        self.watch(name, values.iter().copied());
        self.push(name, true, Arc::new(Float64Array::from(values)));
    }

    pub(super) fn texts<'a>(&mut self, name: &str, values: impl Iterator<Item = &'a str>) {
        self.push(name, false, Arc::new(StringArray::from_iter_values(values)));
    }

    pub(super) fn optional_texts<'a>(
        &mut self,
        name: &str,
        values: impl Iterator<Item = Option<&'a str>>,
    ) {
        self.push(name, true, Arc::new(values.collect::<StringArray>()));
    }

    pub(super) fn optional_flags(
        &mut self,
        name: &str,
        values: impl Iterator<Item = Option<bool>>,
    ) {
        self.push(name, true, Arc::new(values.collect::<BooleanArray>()));
    }

    /// Rows of equal length make a fixed-size list, others a list. A column of empty rows is left out, because Parquet has
    /// no list of length zero.
    pub(super) fn vectors<'a>(&mut self, name: &str, rows: impl Iterator<Item = &'a [f64]>) {
        self.lists(name, false, &rows.map(Some).collect::<Vec<_>>());
    }

    /// As [`Columns::vectors`], with nulls. A column of nulls is left out.
    pub(super) fn optional_vectors<'a>(
        &mut self,
        name: &str,
        rows: impl Iterator<Item = Option<&'a [f64]>>,
    ) {
        self.lists(name, true, &rows.collect::<Vec<_>>());
    }

    fn lists(&mut self, name: &str, nullable: bool, rows: &[Option<&[f64]>]) {
        let given = || rows.iter().copied().flatten();
        for (row, values) in rows.iter().enumerate() {
            let mut values = values.iter().copied().flatten().copied();
            if let Some(value) = values.find(|value| !value.is_finite()) {
                self.report(
                    row,
                    Fault::NotFinite {
                        column: name.to_owned(),
                        value,
                    },
                );
            }
        }
        let width = given().next().map_or(0, <[f64]>::len);
        let fixed = given()
            .all(|row| row.len() == width)
            .then(|| i32::try_from(width).ok())
            .flatten();
        match fixed {
            Some(0) => {}
            Some(fixed) => {
                let mut list = FixedSizeListBuilder::new(Float64Builder::new(), fixed)
                    .with_field(element(DataType::Float64));
                // A null takes the place of its numbers, too.
                let empty = vec![0.0; width];
                for row in rows {
                    list.values().append_slice(row.unwrap_or(&empty));
                    list.append(row.is_some());
                }
                self.push(name, nullable, Arc::new(list.finish()));
            }
            None => self.numbers::<Float64Type>(name, nullable, rows.iter().copied()),
        }
    }

    pub(super) fn indices<'a>(&mut self, name: &str, rows: impl Iterator<Item = &'a [u32]>) {
        self.numbers::<UInt32Type>(name, false, rows.map(Some));
    }

    pub(super) fn ids<'a>(&mut self, name: &str, rows: impl Iterator<Item = &'a [u64]>) {
        self.numbers::<UInt64Type>(name, false, rows.map(Some));
    }

    pub(super) fn text_lists<'a>(&mut self, name: &str, rows: impl Iterator<Item = Vec<&'a str>>) {
        let mut list = ListBuilder::new(StringBuilder::new()).with_field(element(DataType::Utf8));
        for row in rows {
            list.append_value(row.into_iter().map(Some));
        }
        self.push(name, false, Arc::new(list.finish()));
    }

    fn numbers<'a, T: ArrowPrimitiveType>(
        &mut self,
        name: &str,
        nullable: bool,
        rows: impl Iterator<Item = Option<&'a [T::Native]>>,
    ) {
        let mut list =
            ListBuilder::new(PrimitiveBuilder::<T>::new()).with_field(element(T::DATA_TYPE));
        for row in rows {
            list.values().append_slice(row.unwrap_or_default());
            list.append(row.is_some());
        }
        self.push(name, nullable, Arc::new(list.finish()));
    }

    fn push(&mut self, name: &str, nullable: bool, array: ArrayRef) {
        self.fields
            .push(Field::new(name, array.data_type().clone(), nullable));
        self.arrays.push(array);
    }

    fn watch(&mut self, name: &str, values: impl Iterator<Item = Option<f64>>) {
        for (row, value) in values.enumerate() {
            if let Some(value) = value.filter(|value| !value.is_finite()) {
                self.report(
                    row,
                    Fault::NotFinite {
                        column: name.to_owned(),
                        value,
                    },
                );
            }
        }
    }

    fn report(&mut self, row: usize, fault: Fault) {
        if self.fault.as_ref().is_none_or(|(first, _)| row < *first) {
            self.fault = Some((row, fault));
        }
    }

    /// The table as a Parquet file. Equal content gives equal bytes.
    pub(super) fn encode(self, path: &Path, metadata: &str) -> Result<Vec<u8>, StoreError> {
        if let Some((row, fault)) = self.fault {
            return Err(StoreError::Row {
                path: path.to_path_buf(),
                row,
                fault,
            });
        }
        let properties = WriterProperties::builder()
            .set_compression(Compression::SNAPPY)
            .set_created_by(format!("{}{}", sum::WRITER, env!("CARGO_PKG_VERSION")))
            .set_key_value_metadata(Some(vec![
                KeyValue::new(KEY.to_owned(), metadata.to_owned()),
                // The checksum is not in the schema. Programs that rewrite the table would copy it, and it would not fit.
                KeyValue::new(sum::KEY.to_owned(), sum::PLACE.to_owned()),
            ]))
            .build();
        // The metadata are also in Arrow's copy of the schema, because pyarrow keeps no others if that copy exists. There they
        // are an attribute of a data frame, because pandas keeps nothing else. One copy serves both: it is large.
        let metadata =
            HashMap::from([(ATTRIBUTES.to_owned(), format!("{{\"{KEY}\":{metadata}}}"))]);
        let schema = Arc::new(Schema::new(self.fields).with_metadata(metadata));
        let batch = RecordBatch::try_new(Arc::clone(&schema), self.arrays)
            .expect("columns have one length and their own type");
        let mut writer = ArrowWriter::try_new(Vec::new(), schema, Some(properties))
            .expect("all types exist in Parquet");
        writer.write(&batch).expect("memory takes every batch");
        let mut bytes = writer.into_inner().expect("memory takes the footer");
        sum::fill(&mut bytes);
        Ok(bytes)
    }
}

/// The field of a list's elements, with the name required by the Parquet specification.
fn element(data_type: DataType) -> FieldRef {
    Arc::new(Field::new("element", data_type, false))
}
