//! Progress bars on standard error.

use indicatif::{ProgressBar, ProgressStyle};

/// A bar over `total` things called `what`; hidden where nobody looks.
pub(super) fn bar(what: &str, total: u64, quiet: bool) -> ProgressBar {
    if quiet {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new(total);
    let style =
        ProgressStyle::with_template("{msg:>24} {bar:32} {pos}/{len} in {elapsed}, {eta} left")
            .expect("the template is a constant")
            .progress_chars("━╸ ");
    bar.set_style(style);
    bar.set_message(what.to_owned());
    bar
}
