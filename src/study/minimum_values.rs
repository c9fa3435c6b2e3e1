//! Quantities of the minima of a landscape by name: those of its tables, and columns of a user's table.

use crate::figure::LeafValues;
use crate::formats::csv_text;
use crate::store::MinimumRow;

/// Quantities of the minima of a landscape.
#[derive(Debug, Clone, Default)]
pub struct MinimumValues {
    /// Column by column: its name, and the value of each minimum.
    columns: Vec<(String, Vec<f64>)>,
}

impl MinimumValues {
    /// The quantities that every landscape has: `energy`, `members`, and the coordinates `x0`, `x1`, ….
    pub fn of(minima: &[MinimumRow]) -> Self {
        let column = |name: &str, value: &dyn Fn(&MinimumRow) -> f64| {
            (name.to_owned(), minima.iter().map(value).collect())
        };
        let mut columns = vec![
            column("energy", &|row| row.energy),
            column("members", &|row| row.members.len() as f64),
        ];
        let coordinates = minima.iter().map(|row| row.coordinates.len()).min();
        for k in 0..coordinates.unwrap_or(0) {
            columns.push(column(&format!("x{k}"), &|row| row.coordinates[k]));
        }
        Self { columns }
    }

    /// Adds the columns of a table (CSV) with one row for each minimum, whose column `minimum` names it (`m3` or `3`). A
    /// column of the table replaces one of the same name.
    ///
    /// # Errors
    /// A sentence that names the row, if a minimum is missing, unknown or named twice, or a cell is no finite number.
    pub fn add_table(&mut self, text: &str, minima: usize) -> Result<(), String> {
        let (names, rows) = csv_text::table(text, ',', Some('#'))?;
        let key = names.iter().position(|name| name == "minimum");
        let key = key.ok_or("it has no column `minimum` with names such as m3")?;
        let mut values = vec![vec![f64::NAN; minima]; names.len()];
        let mut seen = vec![false; minima];
        for (line, row) in rows {
            let name = row.get(key).map_or("", String::as_str).trim();
            let number = name.strip_prefix('m').unwrap_or(name).parse::<usize>();
            let minimum = number.ok().filter(|number| *number < minima);
            let minimum = minimum.ok_or_else(|| {
                format!(
                    "line {line}: `{name}` is not a minimum of the landscape, which has m0 to m{}",
                    minima.saturating_sub(1)
                )
            })?;
            if std::mem::replace(&mut seen[minimum], true) {
                return Err(format!("line {line}: m{minimum} is named twice"));
            }
            for (column, cell) in row.iter().enumerate().filter(|(column, _)| *column != key) {
                let number = cell
                    .trim()
                    .parse()
                    .ok()
                    .filter(|value: &f64| value.is_finite());
                // Columns of text may stand beside the numbers; they cannot be drawn.
                values[column][minimum] = number.unwrap_or(f64::NAN);
            }
        }
        if let Some(missing) = seen.iter().position(|seen| !seen) {
            return Err(format!("it has no row for m{missing}"));
        }
        for (column, (name, values)) in names.into_iter().zip(values).enumerate() {
            if column != key {
                self.columns.retain(|(known, _)| *known != name);
                self.columns.push((name, values));
            }
        }
        Ok(())
    }

    /// The quantity with this name.
    ///
    /// # Errors
    /// A sentence that lists the names, if there is no such quantity or it is not a number for every minimum.
    pub fn named(&self, name: &str) -> Result<LeafValues, String> {
        let Some((_, values)) = self.columns.iter().find(|(known, _)| known == name) else {
            let names: Vec<&str> = self.columns.iter().map(|(name, _)| name.as_str()).collect();
            return Err(format!(
                "no quantity is called `{name}`; the quantities are {}",
                names.join(", ")
            ));
        };
        if let Some(minimum) = values.iter().position(|value| !value.is_finite()) {
            return Err(format!("`{name}` of m{minimum} is not a finite number"));
        }
        Ok(LeafValues {
            name: name.to_owned(),
            values: values.clone(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_are_read_by_the_names_of_minima() {
        let row = |energy| MinimumRow {
            energy,
            coordinates: vec![2.0 * energy],
            ..MinimumRow::default()
        };
        let mut values = MinimumValues::of(&[row(1.0), row(2.0)]);
        assert_eq!(values.named("x0").unwrap().values, [2.0, 4.0]);
        values
            .add_table("minimum,q4,note\nm1,0.5,a\n0,0.25,b\n", 2)
            .unwrap();
        assert_eq!(values.named("q4").unwrap().values, [0.25, 0.5]);
        assert!(values.named("note").unwrap_err().contains("m0"));
        assert!(
            values
                .named("q6")
                .unwrap_err()
                .contains("energy, members, x0, q4, note")
        );
        for (text, said) in [
            ("q4\n1\n", "no column `minimum`"),
            ("minimum,q\nm2,1\n", "m0 to m1"),
            ("minimum,q\nm1,1\nm1,2\n", "twice"),
            ("minimum,q\nm1,1\n", "no row for m0"),
        ] {
            let error = values.add_table(text, 2).unwrap_err();
            assert!(error.contains(said), "{error}");
        }
    }
}
