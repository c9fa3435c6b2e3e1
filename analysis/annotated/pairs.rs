//! Grasps of one object that are nearly the same: do they have the same label?

use std::collections::BTreeSet;
use std::fmt::Write;

use crate::case::{Case, Measure};
use crate::report::{View, percent};

/// Root mean square of the differences of the joints.
const JOINTS_RAD: f64 = 0.1;
/// Mean difference of the distances of palm and bones, each clamped to this range.
const GAPS_MM: f64 = 3.0;
const CLAMP_MM: [f64; 2] = [-5.0, 15.0];

fn near(a: &Case, b: &Case) -> bool {
    let squares = a.x[7..].iter().zip(&b.x[7..]);
    let squares: Vec<f64> = squares.map(|(a, b)| (a - b) * (a - b)).collect();
    let [low, high] = CLAMP_MM;
    let gaps = a.contact.bones_mm.iter().zip(&b.contact.bones_mm);
    let gaps: Vec<f64> = gaps
        .map(|(a, b)| (a.clamp(low, high) - b.clamp(low, high)).abs())
        .collect();
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    mean(&squares).sqrt() < JOINTS_RAD && mean(&gaps) < GAPS_MM
}

/// A section on pairs of nearly equal grasps.
pub(crate) fn near_pairs(views: &[View<'_>]) -> String {
    let mut text = format!(
        "\n## Nearly equal grasps: what a second annotator might decide\n\n\
         Nobody named these grasps a second time. Pairs of one object are nearly the same: joints within {JOINTS_RAD} rad (root \
         mean square), and palm and bones within {GAPS_MM:.0} mm of the same distance to the object (mean). Their labels give an \
         upper bound of the agreement of two people, because the same person probably named both.\n\n\
         | grasps | pairs | grasps in pairs | same category, % | same cell, % | same type, % | same parts touch, % |\n\
         |---|---|---|---|---|---|---|\n"
    );
    for view in views.iter().filter(|view| view.posed_by_people) {
        let cases = &view.cases;
        let pairs: Vec<[&Case; 2]> = (0..cases.len())
            .flat_map(|i| (0..i).map(move |j| [cases[i], cases[j]]))
            .filter(|[a, b]| a.object == b.object && near(a, b))
            .collect();
        let own: BTreeSet<&str> = pairs.iter().flatten().map(|case| &*case.id).collect();
        let share = |same: &dyn Fn(&Case, &Case) -> bool| {
            let count = pairs.iter().filter(|[a, b]| same(a, b)).count();
            percent(count as f64 / pairs.len() as f64)
        };
        let class =
            |measure: Measure| share(&move |a, b| measure.class(a.truth) == measure.class(b.truth));
        let touch = |case: &Case| case.contact.touching(crate::contact::NEAR_MM);
        let _ = writeln!(
            text,
            "| {} | {} | {} | {} | {} | {} | {} |",
            view.short,
            pairs.len(),
            own.len(),
            class(Measure::Category),
            class(Measure::Cell),
            class(Measure::Type),
            share(&|a, b| touch(a) == touch(b)),
        );
    }
    text
}
