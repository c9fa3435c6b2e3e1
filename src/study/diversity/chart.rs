//! The picture of a comparison: effective numbers with their intervals, side by side.

use super::{DiversityComparison, Measure};
use crate::figure::chart::{Axis, Chart, Panel, Series};
use crate::figure::theme;

/// Part of the distance between two orders over which the sets of one order are spread.
const SPREAD: f64 = 0.6;

impl DiversityComparison {
    /// A panel for each measure: the sets side by side at orders 0, 1 and 2, with their 95 % intervals.
    pub fn chart(&self) -> Chart {
        let panels = self.measures.iter().map(|measure| self.panel(measure));
        let panels: Vec<Panel> = panels.collect();
        Chart {
            columns: panels.len().clamp(1, 2),
            panel_size: [640, 520],
            legend_below: true,
            ..Chart::new("", panels)
        }
    }

    fn panel(&self, measure: &Measure) -> Panel {
        let sets = measure.sets.len();
        let mut series = Vec::new();
        let mut highest = 1.0_f64;
        for (set, numbers) in measure.sets.iter().enumerate() {
            let Some(numbers) = numbers else {
                continue;
            };
            let colour = theme::series(set);
            let shift = SPREAD * ((set as f64 + 0.5) / sets as f64 - 0.5);
            let mut points = Vec::new();
            for (order, number) in numbers.iter().enumerate() {
                let x = order as f64 + shift;
                let [low, high] = number.interval;
                highest = highest.max(high);
                series.push(Series::line(vec![[x, low], [x, high]]).coloured(colour));
                points.push([x, number.value]);
            }
            series.push(
                Series::points(points)
                    .named(&self.names[set])
                    .coloured(colour),
            );
        }
        let orders = (0..3).map(|order| (f64::from(order), format!("order {order}")));
        Panel::new(
            &format!("{} (of {} grasps)", measure.of.name(), measure.grasps),
            Axis::linear("").with_range(-0.5, 2.5).with_ticks(orders),
            Axis::linear("effective number").with_range(0.0, 1.08 * highest),
            series,
        )
    }
}
