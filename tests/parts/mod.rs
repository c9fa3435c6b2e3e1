//! The columns of a valid Parquet file of grasps, as a basis for invalid files.

use std::fs;
use std::path::Path;
use std::sync::Arc;

use arrow_array::cast::AsArray;
use arrow_array::types::Float64Type;
use arrow_array::{Array, ArrayRef, RecordBatch};
use parquet::arrow::ArrowWriter;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;

pub(crate) struct Parts {
    pub(crate) columns: Vec<(String, ArrayRef)>,
    pub(crate) metadata: Option<String>,
    /// The checksum as another program may keep it, although it no longer fits.
    checksum: Option<String>,
}

impl Parts {
    pub(crate) fn of(path: &Path) -> Self {
        let builder =
            ParquetRecordBatchReaderBuilder::try_new(bytes::Bytes::from(fs::read(path).unwrap()))
                .unwrap();
        let pairs = builder
            .metadata()
            .file_metadata()
            .key_value_metadata()
            .unwrap();
        let value = |key: &str| {
            let found = pairs.iter().find(|pair| pair.key == key);
            found.and_then(|pair| pair.value.clone())
        };
        let [metadata, checksum] = ["landscape", "landscape_checksum"].map(value);
        let batch = builder.build().unwrap().next().unwrap().unwrap();
        let columns = batch
            .schema()
            .fields()
            .iter()
            .map(|field| field.name().clone())
            .zip(batch.columns().to_vec())
            .collect();
        Self {
            columns,
            metadata,
            checksum,
        }
    }

    pub(crate) fn set(mut self, name: &str, array: impl Array + 'static) -> Self {
        self.columns
            .iter_mut()
            .find(|(column, _)| column == name)
            .unwrap()
            .1 = Arc::new(array);
        self
    }

    pub(crate) fn without(mut self, name: &str) -> Self {
        let before = self.columns.len();
        self.columns.retain(|(column, _)| column != name);
        assert_eq!(self.columns.len(), before - 1);
        self
    }

    pub(crate) fn floats(&self, name: &str) -> Vec<f64> {
        self.columns
            .iter()
            .find(|(column, _)| column == name)
            .unwrap()
            .1
            .as_primitive::<Float64Type>()
            .values()
            .to_vec()
    }

    pub(crate) fn write(self, path: &Path) {
        let batch = RecordBatch::try_from_iter_with_nullable(
            self.columns
                .into_iter()
                .map(|(name, array)| (name, array, true)),
        )
        .unwrap();
        let pairs = [
            ("landscape", self.metadata),
            ("landscape_checksum", self.checksum),
        ];
        let pairs = pairs
            .into_iter()
            .filter_map(|(key, text)| Some(KeyValue::new(key.into(), text?)));
        let properties = WriterProperties::builder()
            .set_key_value_metadata(Some(pairs.collect()))
            .build();
        let mut writer = ArrowWriter::try_new(
            fs::File::create(path).unwrap(),
            batch.schema(),
            Some(properties),
        )
        .unwrap();
        writer.write(&batch).unwrap();
        writer.close().unwrap();
    }
}
