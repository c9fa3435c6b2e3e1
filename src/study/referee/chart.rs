//! The picture of a judgement: a small panel for each test and each measure, with the sets side by side.

use super::report::shown_unit;
use super::verdict::Verdicts;
use crate::figure::chart::{Axis, Chart, Panel, Series};
use crate::figure::theme;

/// A value of a set and the ends of its interval; `None` if the set does not have it.
type Shown = Option<(f64, Option<[f64; 2]>)>;

impl Verdicts {
    /// A panel for each test, and for each measure that some set has; the sets stand side by side with their 95 % intervals.
    pub fn chart(&self) -> Chart {
        let mut panels = Vec::new();
        for (place, test) in self.settings.tests.iter().enumerate() {
            let found = self.sets.iter().map(|set| {
                let verdict = &set.tests[place];
                let percent = |share: f64| 100.0 * share;
                Some((percent(verdict.holds), Some(verdict.interval.map(percent))))
            });
            panels.extend(self.panel(&test.name, "hold (%)", &found.collect::<Vec<Shown>>(), true));
        }
        for (place, measure) in self.settings.measures.iter().enumerate() {
            let (factor, unit) = shown_unit(*measure);
            let found = self.sets.iter().map(|set| {
                let found = &set.measures[place];
                let interval = found.interval.map(|ends| ends.map(|end| factor * end));
                Some((factor * found.value?, interval))
            });
            let found: Vec<Shown> = found.collect();
            panels.extend(self.panel(measure.name(), unit, &found, false));
        }
        Chart {
            columns: panels.len().clamp(1, 4),
            panel_size: [600, 420],
            legend_below: true,
            ..Chart::new("", panels)
        }
    }

    /// The panel of one row of the table; `None` if no set has a value.
    fn panel(&self, title: &str, unit: &str, found: &[Shown], percent: bool) -> Option<Panel> {
        let ends = || {
            let known = found.iter().flatten();
            known.flat_map(|(value, interval)| interval.iter().flatten().copied().chain([*value]))
        };
        let highest = ends().max_by(f64::total_cmp)?;
        let lowest = ends().fold(0.0, f64::min);
        let mut series = Vec::new();
        for (set, shown) in found.iter().enumerate() {
            let Some((value, interval)) = shown else {
                continue;
            };
            let (x, colour) = (set as f64, theme::series(set));
            if let Some([low, high]) = interval {
                series.push(Series::line(vec![[x, *low], [x, *high]]).coloured(colour));
            }
            let points = Series::points(vec![[x, *value]]);
            series.push(points.named(&self.sets[set].name).coloured(colour));
        }
        let room = if percent {
            100.0
        } else {
            highest.max(lowest + 1e-9)
        };
        let x = Axis::linear("").with_range(-0.7, found.len() as f64 - 0.3);
        Some(Panel::new(
            title,
            x.with_ticks((0..found.len()).map(|set| (set as f64, String::new()))),
            Axis::linear(unit).with_range(lowest, lowest + 1.06 * (room - lowest)),
            series,
        ))
    }
}
