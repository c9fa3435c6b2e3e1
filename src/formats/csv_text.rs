//! CSV tables (RFC 4180).

/// The trimmed fields of each non-empty record, with the number of its first line. Fields may be quoted, and a quote inside
/// is doubled. White space before a quote is skipped, and so are lines that begin with `comment`.
pub(crate) fn records(
    text: &str,
    delimiter: char,
    comment: Option<char>,
) -> Result<Vec<(usize, Vec<String>)>, String> {
    let mut records = Vec::new();
    let (mut line, mut first) = (1, 1);
    let (mut fields, mut field) = (Vec::new(), String::new());
    let mut quoted = false;
    let text = text.trim_start_matches('\u{feff}');
    let mut letters = text.chars().chain(['\n']).peekable();
    while let Some(mut letter) = letters.next() {
        if comment == Some(letter) && fields.is_empty() && field.is_empty() && !quoted {
            letter = letters.find(|letter| *letter == '\n').unwrap_or('\n');
        }
        line += usize::from(letter == '\n');
        match letter {
            '"' if quoted && letters.peek() == Some(&'"') => {
                letters.next();
                field.push('"');
            }
            '"' if quoted || field.trim().is_empty() => quoted = !quoted,
            letter if quoted => field.push(letter),
            letter if letter == delimiter || letter == '\n' => {
                fields.push(std::mem::take(&mut field).trim().to_owned());
                if letter == '\n' {
                    let record = std::mem::take(&mut fields);
                    if record.iter().any(|field| !field.is_empty()) {
                        records.push((first, record));
                    }
                    first = line;
                }
            }
            letter => field.push(letter),
        }
    }
    if quoted {
        return Err(format!("line {first}: a quote is opened and not closed"));
    }
    Ok(records)
}

/// A table: its header and, for each other record, its line number and as many fields as in the header.
pub(crate) type Table = (Vec<String>, Vec<(usize, Vec<String>)>);

/// Reads a table whose first record names the columns. The arguments are those of [`records`].
pub(crate) fn table(text: &str, delimiter: char, comment: Option<char>) -> Result<Table, String> {
    let mut records = records(text, delimiter, comment)?;
    if records.is_empty() {
        return Ok(Table::default());
    }
    let (_, header) = records.remove(0);
    match records
        .iter()
        .find(|(_, fields)| fields.len() != header.len())
    {
        Some((line, fields)) => Err(format!(
            "line {line} has {} fields, but the first line has {}",
            fields.len(),
            header.len()
        )),
        None => Ok((header, records)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_and_quotes_are_known() {
        let text = "\u{feff}# a \"note\", \"open\na,b\r\n#\n\"1\n\"\"2\", \"x, y\"\n,\n3,4";
        let (header, rows) = table(text, ',', Some('#')).unwrap();
        assert_eq!(header, ["a", "b"]);
        let expected = [(4, ["1\n\"2", "x, y"]), (7, ["3", "4"])];
        assert_eq!(
            rows,
            expected.map(|(line, row)| (line, row.map(str::to_owned).to_vec()))
        );
        assert!(
            table("a,b\n1\n", ',', None)
                .unwrap_err()
                .contains("line 2 has 1")
        );
    }
}
