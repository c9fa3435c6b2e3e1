//! The magnetisation diagram: thresholds, groups and stability against temperature and force.

use super::chart::{Axis, BandPoint, Chart, Mark, Panel, Series};
use super::theme::{INK, sequential, series};
use crate::topography::{Diagram, Isotherm, Threshold};

/// Chart of three panels: the forces between which chains become certain to arrive (median over pairs and directions, with
/// quartiles), the number of groups, and the agreement between replicas. `unit` is the unit of the force.
pub fn diagram_chart(title: &str, unit: &str, diagram: &Diagram) -> Chart {
    let force = if unit.is_empty() {
        "force F = αT".to_owned()
    } else {
        format!("force F = αT ({unit})")
    };
    let rows = &diagram.isotherms;
    let level = |value: fn(&crate::topography::ForceLevel) -> f64| -> Vec<Series> {
        let isotherm = |(k, row): (usize, &Isotherm)| {
            let points: Vec<[f64; 2]> = (row.levels.iter())
                .map(|level| [level.force, value(level)])
                .collect();
            let colour = sequential(0.9 * k as f64 / rows.len().max(2) as f64);
            Series::line(points)
                .named(&format!("T = {}", super::number(row.temperature)))
                .coloured(colour)
        };
        let mut marks: Vec<Series> = rows.iter().enumerate().map(isotherm).collect();
        marks.extend(diagram.recommended.iter().map(|best| {
            let rule = Series::new(Mark::Vertical(best.force));
            rule.dashed().coloured(INK)
        }));
        marks
    };
    let axis = || Axis::logarithmic(&force);
    let panels = vec![
        thresholds(&force, diagram),
        Panel::new(
            "groups of the sample",
            axis(),
            Axis::linear("groups"),
            level(|level| level.groups),
        ),
        Panel::new(
            "agreement of replicas",
            axis(),
            Axis::linear("adjusted Rand index").with_range(0.0, 1.05),
            level(|level| level.stability),
        ),
    ];
    Chart {
        legend_below: true,
        ..Chart::new(title, panels)
    }
}

/// Selects one of the forces of a threshold.
type Value = fn(&Threshold) -> Option<f64>;

fn thresholds(force: &str, diagram: &Diagram) -> Panel {
    let mut marks = Vec::new();
    let kinds: [(&str, Value); 2] = [
        ("first chain arrives", |threshold| threshold.first),
        ("all chains arrive", |threshold| threshold.always),
    ];
    for (k, (name, value)) in kinds.into_iter().enumerate() {
        // A threshold beyond the grid is unknown but higher than all others.
        let quartile = |row: &Isotherm, quarters: usize| {
            let mut values: Vec<f64> = (row.thresholds.iter())
                .map(|threshold| value(threshold).unwrap_or(f64::INFINITY))
                .collect();
            values.sort_by(f64::total_cmp);
            let place = quarters * values.len().saturating_sub(1) / 4;
            values.get(place).copied().filter(|value| value.is_finite())
        };
        let band = diagram.isotherms.iter().filter_map(|row| {
            let (lower, upper) = quartile(row, 1).zip(quartile(row, 3))?;
            Some(BandPoint {
                x: row.temperature,
                lower,
                upper,
            })
        });
        let line: Vec<[f64; 2]> = (diagram.isotherms.iter())
            .filter_map(|row| quartile(row, 2).map(|force| [row.temperature, force]))
            .collect();
        let colour = series(k);
        marks.push(Series::band(band.collect()).coloured(colour));
        marks.push(Series::line(line.clone()).named(name).coloured(colour));
        marks.push(Series::points(line).coloured(colour));
    }
    if let Some(best) = &diagram.recommended {
        let place = vec![[best.temperature, best.force]];
        let mark = Mark::Points {
            points: place,
            radius: 12.0,
        };
        marks.push(Series::new(mark).named("recommended").coloured(INK));
    }
    Panel::new(
        "where chains get through",
        Axis::logarithmic("temperature T"),
        Axis::logarithmic(force),
        marks,
    )
}

#[cfg(test)]
mod tests {
    use super::super::testing::{assert_legible, gallery};
    use super::*;
    use crate::energy::model::MullerBrown;
    use crate::optimize::QuenchSettings;
    use crate::sample::Mala;
    use crate::topography::{DiagramSettings, MatchTolerance, Run, diagram, distinct, quench_all};

    #[test]
    fn diagram_of_a_surface() {
        let energy = MullerBrown::new();
        let starts = [vec![-0.56, 1.44], vec![0.62, 0.03], vec![-0.05, 0.47]];
        let settings = QuenchSettings::default();
        let found = quench_all(&energy, &starts, &settings, &Run::default()).unwrap();
        let (minima, _) = distinct(&energy, &found, &MatchTolerance::default(), 1e-6);
        let settings = DiagramSettings {
            replicas: 3,
            ..DiagramSettings::for_scales(50.0, 1.0)
        };
        let kernel = Mala::new(&energy);
        let found = diagram(&energy, &kernel, &minima, &settings, &Run::default()).unwrap();
        let canvas = diagram_chart("Müller and Brown", "", &found)
            .draw()
            .unwrap();
        assert_legible(&canvas);
        gallery(&canvas, "diagram");
        let texts = canvas.texts();
        for expected in ["first chain arrives", "recommended", "adjusted Rand index"] {
            assert!(
                texts.iter().any(|(text, _)| *text == expected),
                "{expected}"
            );
        }
    }
}
