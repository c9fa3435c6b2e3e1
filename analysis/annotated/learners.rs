//! What learners reach that have seen people's grasps.

use std::fmt::Write;

use crate::case::{Case, Measure, Who};
use crate::report::{View, over_objects, per_type, told, types_of, with_interval};

const MEASURES: [Measure; 3] = [Measure::Category, Measure::Cell, Measure::Type];

/// A sentence: how far the learners are from the rule on these grasps.
fn beside_the_rule(view: &View<'_>) -> String {
    let pairs = Who::LEARNERS
        .iter()
        .flat_map(|who| MEASURES.map(|measure| (*who, measure)));
    let gains = |cases: &[&Case]| {
        let gain = |(who, measure)| told(cases, who, measure) - told(cases, Who::Rule, measure);
        let gains: Vec<f64> = pairs.clone().map(gain).collect();
        [
            gains.iter().copied().fold(f64::NEG_INFINITY, f64::max),
            gains.iter().copied().fold(f64::INFINITY, f64::min),
        ]
    };
    let [most, least] = gains(&view.cases);
    let [most_agreeing, least_agreeing] = gains(&view.agreeing());
    format!(
        "Of category, cell and type of all {} grasps they name between {:+.1} and {:+.1} percentage points more than the rule, and \
         between {:+.1} and {:+.1} of those whose label agrees with contact. So these learners get no further than the rule, with \
         its facts or with others. What more grasps would teach, {} do not tell. ",
        view.cases.len(),
        100.0 * least,
        100.0 * most,
        100.0 * least_agreeing,
        100.0 * most_agreeing,
        view.cases.len(),
    )
    .replace('-', "−")
}

/// Two tables: per grasp, and as mean over types, each with intervals.
pub(crate) fn learners(views: &[View<'_>]) -> String {
    let mut text = format!(
        "\n## What learners reach\n\n\
         *Learner*: multinomial logistic regression on the facts, forms and width that the rule sees. *Second learner*: \
         extremely randomised trees on other facts, the distance of each bone and the angles of the joints. Both have seen \
         people's grasps of all other objects, which the rule has not. {}The 76, 62 and 55 % of an earlier learner could \
         not be reproduced from these data.\n",
        views
            .iter()
            .find(|view| view.short == "all")
            .map_or(String::new(), beside_the_rule)
    );
    for by_type in [false, true] {
        let _ = write!(
            text,
            "\n{}, %:\n\n| who | grasps | number | category | 95 % interval | cell | 95 % interval | type | 95 % interval |\n\
             |---|---|---|---|---|---|---|---|---|\n",
            if by_type {
                "Mean over types"
            } else {
                "Per grasp"
            }
        );
        for view in views.iter().filter(|view| view.posed_by_people) {
            let agreeing = view.agreeing();
            for (cases, kind) in [
                (&view.cases, ""),
                (&agreeing, ", label agrees with contact"),
            ] {
                for who in [Who::Rule, Who::Regression, Who::Trees] {
                    let _ = write!(
                        text,
                        "| {} | {}{kind} | {} |",
                        who.name(),
                        view.short,
                        cases.len()
                    );
                    let types = types_of(cases, 1);
                    for measure in MEASURES {
                        let share = |cases: &[&Case]| {
                            if by_type {
                                per_type(cases, who, measure, &types)
                            } else {
                                told(cases, who, measure)
                            }
                        };
                        let _ = write!(text, " {} |", with_interval(over_objects(cases, &share)));
                    }
                    text.push('\n');
                }
            }
        }
    }
    text
}
