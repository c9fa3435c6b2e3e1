//! Tables of cases in texts.

/// The rows of a table: a line each, whose cells stand between ` | `. Lines without content are left out.
pub(crate) fn rows(table: &str) -> impl Iterator<Item = Vec<&str>> {
    let lines = table.lines().map(str::trim).filter(|line| !line.is_empty());
    lines.map(|line| line.split(" | ").map(str::trim).collect())
}
