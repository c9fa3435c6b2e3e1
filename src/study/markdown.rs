//! Tables in Markdown.

use std::fmt::Write;

/// A table with a line for each row, without columns of which nothing is known (empty cells and dashes).
pub(super) fn table(head: &[&str], rows: impl IntoIterator<Item = Vec<String>>) -> String {
    let rows: Vec<Vec<String>> = rows.into_iter().collect();
    let known = |column: &usize| {
        let mut cells = rows.iter().map(|row| row[*column].as_str());
        rows.is_empty() || cells.any(|cell| !matches!(cell, "" | "–"))
    };
    let columns: Vec<usize> = (0..head.len()).filter(known).collect();
    let mut text = String::new();
    let mut line = |cells: Vec<&str>| {
        let _ = writeln!(text, "| {} |", cells.join(" | "));
    };
    line(columns.iter().map(|column| head[*column]).collect());
    line(columns.iter().map(|_| "---").collect());
    for row in &rows {
        line(columns.iter().map(|column| row[*column].as_str()).collect());
    }
    text
}
