//! Writing `min.data` and `ts.data`.

use super::{Database, Layout, Vibrations};

impl Database {
    /// The text of `min.data`. Numbers are written without loss in columns of fixed width.
    pub fn min_data(&self, layout: Layout) -> String {
        let minima = self.minima.iter().enumerate();
        minima
            .map(|(row, minimum)| match layout {
                Layout::Pathsample => {
                    let (before, after) = columns(minimum.vibrations);
                    format!("{} {before} {after}\n", number(minimum.energy))
                }
                Layout::Topsearch => format!("{row:>8} {}\n", number(minimum.energy)),
            })
            .collect()
    }

    /// The text of `ts.data`.
    pub fn ts_data(&self, layout: Layout) -> String {
        let states = self.transition_states.iter();
        states
            .map(|state| {
                let energy = number(state.energy);
                match layout {
                    Layout::Pathsample => {
                        let (before, after) = columns(state.vibrations);
                        let [a, b] = state.ends.map(|end| end + 1);
                        format!("{energy} {before} {a:>8} {b:>8} {after}\n")
                    }
                    Layout::Topsearch => {
                        let [a, b] = state.ends;
                        format!("{a:>8} {b:>8} {energy}\n")
                    }
                }
            })
            .collect()
    }
}

/// An ln-product of 0 that is known is written so where nothing else would tell it from the placeholders. It is 0 in any
/// sum with a number of usual size.
const KNOWN_ZERO: f64 = 1e-300;

/// The columns of ln-product and order, and those of the moments of inertia.
fn columns(vibrations: Option<Vibrations>) -> (String, String) {
    let written = |known: Vibrations| Vibrations {
        log_product: if known.looks_unknown() {
            KNOWN_ZERO
        } else {
            known.log_product
        },
        ..known
    };
    let vibrations = vibrations.map(written).unwrap_or_default();
    let before = format!(
        "{} {:>6}",
        number(vibrations.log_product),
        vibrations.point_group_order
    );
    (before, vibrations.moments_of_inertia.map(number).join(" "))
}

/// The shortest text that is read back as the same number, right-aligned.
fn number(value: f64) -> String {
    let plain = value == 0.0 || (1e-5..1e15).contains(&value.abs());
    if plain {
        format!("{value:>25?}")
    } else {
        format!("{value:>25e}")
    }
}
