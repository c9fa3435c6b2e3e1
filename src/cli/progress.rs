//! Progress bars on standard error.

use std::sync::LazyLock;

use indicatif::{MultiProgress, ProgressBar, ProgressStyle};

/// All bars, so that they can be taken off the terminal.
static BARS: LazyLock<MultiProgress> = LazyLock::new(MultiProgress::new);

/// Does something while no bar is on the terminal, and none can come.
pub(super) fn without_bars<T>(work: impl FnOnce() -> T) -> T {
    BARS.suspend(work)
}

/// A bar over `total` things called `what`; hidden where nobody looks.
pub(super) fn bar(what: &str, total: u64, quiet: bool) -> ProgressBar {
    if quiet {
        return ProgressBar::hidden();
    }
    let bar = BARS.add(ProgressBar::new(total));
    let style =
        ProgressStyle::with_template("{msg:>24} {bar:32} {pos}/{len} in {elapsed}, {eta} left")
            .expect("the template is a constant")
            .progress_chars("━╸ ");
    bar.set_style(style);
    bar.set_message(what.to_owned());
    bar
}
