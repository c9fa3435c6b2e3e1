//! Columns of tables. A list of fields, each named once, defines how rows become columns and columns become rows.

use super::columns::Columns;
use super::error::StoreError;
use super::table::{FLAG, FLOAT, IDS, INDICES, TEXT, Table, VECTOR, WHOLE};

/// A type of cells, which defines how its columns are written and read.
pub(super) trait Cell: Sized {
    fn write<'a>(columns: &mut Columns, name: &str, cells: impl Iterator<Item = &'a Self>)
    where
        Self: 'a;

    fn read(table: &Table, name: &str) -> Result<Vec<Self>, StoreError>;
}

/// Implements [`Cell`]. The arguments are the type, its method of [`Columns`] with the value for a cell, and its method of
/// [`Table`] with the accepted kind of column.
macro_rules! cell {
    ($($type:ty: $write:ident($cell:ident => $given:expr), $read:ident($kind:expr);)*) => {$(
        impl Cell for $type {
            fn write<'a>(columns: &mut Columns, name: &str, cells: impl Iterator<Item = &'a Self>)
            where
                Self: 'a,
            {
                columns.$write(name, cells.map(|$cell| $given));
            }

            fn read(table: &Table, name: &str) -> Result<Vec<Self>, StoreError> {
                table.$read(name, &$kind)
            }
        }
    )*};
}

cell! {
    u64: wholes(cell => *cell), required(WHOLE);
    f64: floats(cell => *cell), required(FLOAT);
    Option<f64>: optional_floats(cell => *cell), optional(FLOAT);
    Option<bool>: optional_flags(cell => *cell), optional(FLAG);
    String: texts(cell => cell.as_str()), required(TEXT);
    Option<String>: optional_texts(cell => cell.as_deref()), optional(TEXT);
    Vec<f64>: vectors(cell => cell.as_slice()), required(VECTOR);
    Option<Vec<f64>>: optional_vectors(cell => cell.as_deref()), optional(VECTOR);
    Vec<u32>: indices(cell => cell.as_slice()), required(INDICES);
    Vec<u64>: ids(cell => cell.as_slice()), required(IDS);
}

/// A column of a table: its name, and access to its field of a row.
pub(super) struct Column<Row> {
    pub(super) name: &'static str,
    /// Whether a table may lack this column. The fields of its rows are then left as they are.
    pub(super) may_be_absent: bool,
    pub(super) write: fn(&[Row], &str, &mut Columns),
    pub(super) read: fn(&Table, &str, &mut [Row]) -> Result<(), StoreError>,
}

/// A [`Column`]: the name of a field that is also the name of the column, or `column = field`. With `if present`, tables
/// without the column are read too.
macro_rules! column {
    ($name:ident) => {
        crate::store::row::column!($name = $name)
    };
    ($name:ident if present) => {
        crate::store::row::Column {
            may_be_absent: true,
            ..crate::store::row::column!($name)
        }
    };
    ($name:ident = $field:ident $([$index:literal])?) => {
        crate::store::row::Column {
            name: stringify!($name),
            may_be_absent: false,
            write: |rows, name, columns| {
                let cells = rows.iter().map(|row| &row.$field $([$index])?);
                crate::store::row::Cell::write(columns, name, cells);
            },
            read: |table, name, rows| {
                let cells = crate::store::row::Cell::read(table, name)?;
                for (row, cell) in rows.iter_mut().zip(cells) {
                    row.$field $([$index])? = cell;
                }
                Ok(())
            },
        }
    };
}

/// A list of [`Column`]s.
macro_rules! columns {
    ($($name:ident $(= $field:ident $([$index:literal])?)? $(if $present:ident)?),* $(,)?) => {
        &[$(crate::store::row::column!($name $(= $field $([$index])?)? $(if $present)?)),*]
    };
}
pub(super) use {column, columns};

/// Appends the columns of `rows`, in the order of the list.
pub(super) fn write<Row>(list: &[Column<Row>], rows: &[Row], columns: &mut Columns) {
    for column in list {
        (column.write)(rows, column.name, columns);
    }
}

/// Fills the fields of `rows`, of which there are as many as in the table.
pub(super) fn read<Row>(
    list: &[Column<Row>],
    table: &Table,
    rows: &mut [Row],
) -> Result<(), StoreError> {
    for column in list {
        if !column.may_be_absent || table.has(column.name) {
            (column.read)(table, column.name, rows)?;
        }
    }
    Ok(())
}
