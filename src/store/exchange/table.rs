//! Tables from CSV, JSON and Parquet. Cells are numbers, lists of numbers, or texts.

use std::collections::BTreeMap;
use std::path::Path;

use serde_json::Value;

use super::super::error::StoreError;
use super::super::table::{FLOAT, TEXT, VECTOR};
use crate::formats::csv_text;

/// The value of a row in a column.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Cell {
    Number(f64),
    List(Vec<f64>),
    Text(String),
}

/// Rows of named cells. Empty cells are omitted.
#[derive(Debug, Default)]
pub(super) struct Table {
    pub(super) columns: Vec<String>,
    pub(super) rows: Vec<BTreeMap<String, Cell>>,
}

impl Cell {
    /// The numbers of a cell: a number, a list, or a text of numbers separated by spaces, semicolons or commas. The text
    /// may have brackets around the numbers.
    pub(super) fn numbers(&self) -> Option<Vec<f64>> {
        match self {
            Self::Number(number) => Some(vec![*number]),
            Self::List(numbers) => Some(numbers.clone()),
            Self::Text(text) => text
                .trim_start_matches(['[', '('])
                .trim_end_matches([']', ')'])
                .split(|c: char| c.is_whitespace() || matches!(c, ';' | ','))
                .filter(|word| !word.is_empty())
                .map(|word| word.parse().ok())
                .collect(),
        }
    }
}

pub(super) fn of_csv(bytes: &[u8]) -> Result<Table, String> {
    let bad = |problem| format!("it is not a valid CSV table: {problem}");
    let text = str::from_utf8(bytes).map_err(|error| bad(error.to_string()))?;
    let (columns, records) = csv_text::table(text, ',', Some('#')).map_err(bad)?;
    let row = |(_, record): (usize, Vec<String>)| {
        let cells = columns.iter().cloned().zip(record);
        // Cells stay texts: one that looks like a number may be a name, or may have more digits than a floating-point
        // number.
        cells
            .filter(|(_, text)| !text.is_empty())
            .map(|(name, text)| (name, Cell::Text(text)))
            .collect()
    };
    let rows = records.into_iter().map(row).collect();
    Ok(Table { columns, rows })
}

/// Reads a list of objects, or an object whose entry `grasps` is such a list.
pub(super) fn of_json(value: &Value) -> Result<Table, String> {
    let list = value.get("grasps").unwrap_or(value);
    let entries = list
        .as_array()
        .ok_or("it is not a list of grasps, each an object with named entries")?;
    let mut table = Table::default();
    for (place, entry) in entries.iter().enumerate() {
        let entry = entry
            .as_object()
            .ok_or_else(|| format!("entry {place} is not an object with named entries"))?;
        let mut row = BTreeMap::new();
        for (name, value) in entry {
            if !table.columns.contains(name) {
                table.columns.push(name.clone());
            }
            if let Some(cell) = of_value(value) {
                row.insert(name.clone(), cell);
            }
        }
        table.rows.push(row);
    }
    Ok(table)
}

fn of_value(value: &Value) -> Option<Cell> {
    match value {
        // A floating-point number would lose digits.
        Value::Number(number) if number.as_u64().is_some_and(|number| number > 1 << 53) => {
            Some(Cell::Text(number.to_string()))
        }
        Value::Number(number) => number.as_f64().map(Cell::Number),
        Value::String(text) => Some(Cell::Text(text.clone())),
        Value::Array(items) => {
            // Matrices are lists of lists.
            let flat = items.iter().flat_map(|item| match item {
                Value::Array(inner) => inner.iter().collect(),
                other => vec![other],
            });
            flat.map(Value::as_f64)
                .collect::<Option<Vec<f64>>>()
                .map(Cell::List)
        }
        _ => None,
    }
}

/// Reads a Parquet file. Columns of unsupported types are left out.
pub(super) fn of_parquet(path: &Path) -> Result<Table, StoreError> {
    let stored = super::super::table::Table::read(path)?;
    let mut table = Table {
        columns: stored.names().map(str::to_owned).collect(),
        rows: vec![BTreeMap::new(); stored.rows],
    };
    for name in &table.columns {
        let cells: Vec<Option<Cell>> = if let Ok(numbers) = stored.optional(name, &FLOAT) {
            numbers
                .into_iter()
                .map(|cell| cell.map(Cell::Number))
                .collect()
        } else if let Ok(lists) = stored.optional(name, &VECTOR) {
            lists.into_iter().map(|cell| cell.map(Cell::List)).collect()
        } else if let Ok(texts) = stored.optional(name, &TEXT) {
            texts.into_iter().map(|cell| cell.map(Cell::Text)).collect()
        } else {
            continue;
        };
        for (row, cell) in table.rows.iter_mut().zip(cells) {
            if let Some(cell) = cell {
                row.insert(name.clone(), cell);
            }
        }
    }
    Ok(table)
}
