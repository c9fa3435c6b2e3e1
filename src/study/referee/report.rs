//! The tables, the JSON and the CSV of a judgement.

use std::fmt::Write;

use serde_json::{Value, json};

use super::measures::{Better, Measure, Measured};
use super::verdict::{SetVerdict, Verdicts};
use crate::figure::MAKER;
use crate::store::GraspFile;
use crate::study::markdown::table;

impl Verdicts {
    /// Sets × tests, where the tests disagree, sets × measures, and what was derived, as Markdown.
    pub fn markdown(&self) -> String {
        let mut text = String::new();
        let line = |text: &mut String, set: &SetVerdict| {
            let _ = writeln!(
                text,
                "- {}: {} grasps of {} {}",
                set.name,
                set.grasps,
                set.objects,
                if set.objects == 1 {
                    "object"
                } else {
                    "objects"
                }
            );
        };
        for set in &self.sets {
            line(&mut text, set);
        }
        if !self.settings.tests.is_empty() {
            let _ = writeln!(text, "\n## Share of the grasps that hold, %\n");
            text += &self.tests();
            let _ = writeln!(
                text,
                "\nBrackets are 95 % intervals over resampled objects and grasps."
            );
            text += &self.disagreements();
            text += &self.derived();
        }
        if !self.settings.measures.is_empty() {
            let _ = writeln!(text, "\n## Measures\n");
            text += &self.measures();
        }
        if !self.settings.tests.is_empty() {
            text += &self.sources();
        }
        text
    }

    fn heads(&self, first: &'static str) -> Vec<String> {
        let names = self.sets.iter().map(|set| set.name.clone());
        [first.to_owned()].into_iter().chain(names).collect()
    }

    fn tests(&self) -> String {
        let heads = self.heads("test");
        let heads: Vec<&str> = heads.iter().map(String::as_str).collect();
        let rows = self.settings.tests.iter().enumerate().map(|(place, test)| {
            let cell = |set: &SetVerdict| {
                let found = &set.tests[place];
                let [low, high] = found.interval.map(|end| 100.0 * end);
                format!("{:.1} [{low:.1}, {high:.1}]", 100.0 * found.holds)
            };
            let cells = self.sets.iter().map(cell);
            [test.name.clone()].into_iter().chain(cells).collect()
        });
        table(&heads, rows)
    }

    /// What each test is, and where it comes from.
    fn sources(&self) -> String {
        let tests = self.settings.tests.iter();
        let lines =
            tests.map(|test| format!("- **{}.** {} {}\n", test.name, test.about, test.source));
        format!("\n## The tests\n\n{}", lines.collect::<String>())
    }

    /// For each two tests, on how many grasps they disagree.
    fn disagreements(&self) -> String {
        let tests = &self.settings.tests;
        if tests.len() < 2 {
            return String::new();
        }
        let mut text = "\n## Grasps on which two tests disagree, %\n\n".to_owned();
        let heads: Vec<&str> = [""]
            .into_iter()
            .chain(tests.iter().map(|test| test.name.as_str()))
            .collect();
        let rows = tests.iter().enumerate().map(|(a, test)| {
            let cells = self.agreement[a].iter().enumerate().map(|(b, share)| {
                if a == b {
                    "–".to_owned()
                } else {
                    format!("{:.1}", 100.0 * (1.0 - share))
                }
            });
            [test.name.clone()].into_iter().chain(cells).collect()
        });
        text += &table(&heads, rows);
        text
    }

    /// What tests needed and files lacked.
    fn derived(&self) -> String {
        let mut lines = Vec::new();
        for (place, test) in self.settings.tests.iter().enumerate() {
            for set in &self.sets {
                if let Some(derived) = &set.tests[place].derived {
                    lines.push(format!("- {}, {}: {derived}.\n", test.name, set.name));
                }
            }
        }
        if lines.is_empty() {
            return String::new();
        }
        format!(
            "\n## Derived, because a test needs it and the file lacks it\n\n{}",
            lines.concat()
        )
    }

    fn measures(&self) -> String {
        let heads = self.heads("measure");
        let heads: Vec<&str> = heads
            .iter()
            .map(String::as_str)
            .chain(["unit", "better", "counts"])
            .collect();
        let rows = self
            .settings
            .measures
            .iter()
            .enumerate()
            .map(|(place, measure)| {
                let (factor, unit) = shown_unit(*measure);
                let cells = self
                    .sets
                    .iter()
                    .map(|set| shown(&set.measures[place], factor));
                let better = match measure.better() {
                    Better::More => "more",
                    Better::Less => "less",
                    Better::Neither => "",
                };
                let counted = if measure.of_held() { "held" } else { "all" };
                [measure.title().to_owned()]
                    .into_iter()
                    .chain(cells)
                    .chain([unit, better, counted].map(str::to_owned))
                    .collect()
            });
        let mut text = table(&heads, rows);
        if let Some(deciding) = self.settings.deciding() {
            let name = &self.settings.tests[deciding].name;
            let _ = writeln!(
                text,
                "\n“Held” are the grasps that hold in the test {name}."
            );
        }
        match self.settings.resampling.at {
            Some(at) => {
                let _ = writeln!(
                    text,
                    "Every measure sees {at} grasps of each object: the mean over twenty random choices. Objects with fewer do \
                     not count."
                );
            }
            None if self.sets.len() > 1 => {
                let _ = writeln!(
                    text,
                    "Entropies, unique and distinct grasps, effective numbers and the Vendi score grow with the number of grasps: \
                     compare sets of different size with --at."
                );
            }
            None => {}
        }
        text
    }

    /// All numbers as one JSON document.
    pub fn to_json(&self) -> Value {
        let tests = self.settings.tests.iter();
        let tests = tests
            .map(|test| json!({ "name": test.name, "title": test.title, "source": test.source }));
        let measures = self.settings.measures.iter().map(|measure| {
            json!({
                "name": measure.name(),
                "title": measure.title(),
                "unit": measure.unit(),
                "of_held": measure.of_held(),
                "source": measure.source(),
            })
        });
        json!({
            "made_by": MAKER,
            "tests": tests.collect::<Vec<_>>(),
            "measures": measures.collect::<Vec<_>>(),
            "deciding": self.settings.deciding().map(|place| &self.settings.tests[place].name),
            "resampling": self.settings.resampling,
            "sets": self.sets,
            "agreement": self.agreement,
        })
    }

    /// A row for each number: set, what, name, value, ends of its interval, unit, grasps.
    pub fn csv(&self) -> String {
        let mut text = "set,kind,name,value,low,high,unit,grasps\n".to_owned();
        for set in &self.sets {
            let name = quoted(&set.name);
            for (test, found) in self.settings.tests.iter().zip(&set.tests) {
                let [low, high] = found.interval;
                let _ = writeln!(
                    text,
                    "{name},test,{},{},{low},{high},share,{}",
                    test.name, found.holds, set.grasps
                );
            }
            for (measure, found) in self.settings.measures.iter().zip(&set.measures) {
                let [low, high] = found.interval.map_or([None; 2], |ends| ends.map(Some));
                let _ = writeln!(
                    text,
                    "{name},measure,{},{},{},{},{},{}",
                    measure.name(),
                    number(found.value),
                    number(low),
                    number(high),
                    measure.unit(),
                    found.grasps
                );
            }
        }
        text
    }

    /// A row for each grasp: set, id, object, scale, and the reason of each test.
    pub fn csv_of_grasps(&self, files: &[&GraspFile]) -> String {
        let names = self.settings.tests.iter().map(|test| test.name.as_str());
        let head: Vec<&str> = ["set", "id", "hand", "object", "scale"]
            .into_iter()
            .chain(names)
            .collect();
        let mut text = format!("{}\n", head.join(","));
        for (set, file) in self.sets.iter().zip(files) {
            for (place, row) in file.grasps.iter().enumerate() {
                let _ = write!(
                    text,
                    "{},{},{},{},{}",
                    quoted(&set.name),
                    row.id,
                    quoted(&row.hand),
                    quoted(&row.object),
                    row.scale
                );
                for test in &set.tests {
                    let _ = write!(text, ",{}", test.outcomes[place].reason.name());
                }
                text.push('\n');
            }
        }
        text
    }
}

/// The unit in which a measure is shown, and the factor to it: lengths in millimetres.
pub(super) fn shown_unit(measure: Measure) -> (f64, &'static str) {
    match measure.unit() {
        "m" => (1e3, "mm"),
        unit => (1.0, unit),
    }
}

/// A value with its interval, times a factor, to three digits.
fn shown(found: &Measured, factor: f64) -> String {
    match (found.value, found.interval) {
        (Some(value), Some(ends)) => {
            let [low, high] = ends.map(|end| digits(factor * end));
            format!("{} [{low}, {high}]", digits(factor * value))
        }
        (Some(value), None) => digits(factor * value),
        (None, _) => "–".to_owned(),
    }
}

/// A number to three digits, without an exponent.
fn digits(value: f64) -> String {
    let magnitude = value.abs();
    if magnitude >= 100.0 || magnitude == 0.0 {
        format!("{value:.0}")
    } else if magnitude >= 10.0 {
        format!("{value:.1}")
    } else if magnitude >= 0.1 {
        format!("{value:.2}")
    } else {
        format!("{value:.4}")
    }
}

fn number(value: Option<f64>) -> String {
    value.map_or(String::new(), |value| value.to_string())
}

/// A field of a CSV file.
fn quoted(field: &str) -> String {
    if field.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", field.replace('"', "\"\""))
    } else {
        field.to_owned()
    }
}
