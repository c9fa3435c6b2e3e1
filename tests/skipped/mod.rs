//! Tests that are skipped say so, each with its name.

use std::io::Write;

/// Says that the test of this thread is skipped, and why. `.ci/run` collects these lines.
pub(crate) fn skipped(why: &str) {
    let thread = std::thread::current();
    let test = thread.name().unwrap_or("a test");
    // Past the harness, which captures what the print macros write.
    let _ = writeln!(std::io::stderr(), "SKIPPED: {test}: {why}");
}
