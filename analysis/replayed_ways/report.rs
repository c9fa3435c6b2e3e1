//! Tables, statistics and pictures.

use std::fmt::Write;
use std::fs;
use std::path::Path;

use landscape::agreement::{
    bootstrap, cliffs_delta, partial_spearman, sign_test, spearman, wilson,
};
use landscape::evaluation::stability::Replay;
use landscape::figure::chart::{Axis, Chart, Panel, Series};
use landscape::figure::contact_sheet;

use super::Failure;
use super::design::{CONDITIONS, Drive, Kind, SEED, ends};
use super::film::strip;
use super::runs::Driven;

const RESAMPLINGS: usize = 2000;

/// The numbers of an edge or a random pair, in the order of `NUMBERS`; NaN if there is none.
const NUMBERS: [&str; 8] = [
    "barrier",
    "height",
    "length_m",
    "object_m",
    "object_rad",
    "slip_m",
    "compliance",
    "distance_m",
];
const BARRIER: usize = 0;
const LENGTH: usize = 2;
const OBJECT_M: usize = 3;
const OBJECT_RAD: usize = 4;

/// An edge that was driven, or a random pair.
#[derive(Clone, Copy)]
pub(crate) struct Case<'a> {
    set: usize,
    driven: &'a Driven<'a>,
    drive: Drive,
    way: &'a str,
    numbers: [f64; NUMBERS.len()],
    hold: [bool; CONDITIONS],
    succeeds: [bool; CONDITIONS],
    /// Under the main condition, as is how the relaxed way ended.
    straight: bool,
    ending: (&'static str, f64),
}

type Cases<'a> = Vec<Case<'a>>;

impl<'a> Case<'a> {
    fn new(set: usize, driven: &'a Driven<'a>, drive: Drive) -> Self {
        let [from, to] = drive.ends;
        let edge = driven
            .files
            .edges
            .iter()
            .find(|edge| [[from, to], [to, from]].contains(&ends(edge)));
        let of = |value: Option<Option<f64>>| value.flatten().unwrap_or(f64::NAN);
        let [object_m, object_rad] = driven.ways.asked(drive.ends);
        let path = driven.ways.path(drive.ends);
        let [slip_m, compliance] =
            path.map_or([f64::NAN; 2], |way| driven.ways.slip_and_compliance(&way));
        let [barrier, height] = [
            edge.map(|edge| edge.relative_barrier),
            edge.map(|edge| edge.height),
        ]
        .map(of);
        let length_m = of(edge.map(|edge| edge.length));
        Self {
            set,
            driven,
            drive,
            way: edge
                .and_then(|edge| edge.way.as_deref())
                .unwrap_or_default(),
            numbers: [
                barrier,
                height,
                length_m,
                object_m,
                object_rad,
                slip_m,
                compliance,
                driven.ways.distance_m(drive.ends),
            ],
            hold: driven.ends_hold(drive),
            succeeds: driven.successes(drive),
            straight: driven.successes(Drive {
                kind: Kind::Straight,
                ..drive
            })[0],
            ending: driven.ending(drive),
        }
    }

    /// Whether a hand that does nothing would fail.
    fn must_move(&self) -> bool {
        let settings = Replay::default();
        self.numbers[OBJECT_M] > settings.near_m || self.numbers[OBJECT_RAD] > settings.near_rad
    }
}

fn numbers(cases: &[Case<'_>], value: impl Fn(&Case<'_>) -> f64) -> Vec<f64> {
    cases.iter().map(value).collect()
}

fn chosen<'a>(cases: &[Case<'a>], test: impl Fn(&Case<'a>) -> bool) -> Cases<'a> {
    cases.iter().copied().filter(|case| test(case)).collect()
}

fn success(case: &Case<'_>) -> f64 {
    f64::from(u8::from(case.succeeds[0]))
}

/// A statistic of cases, with its 95 % interval: resampled within landscapes.
fn interval(
    cases: &[Case<'_>],
    statistic: &(dyn Fn(&[Case<'_>]) -> f64 + Sync),
) -> (f64, [f64; 2]) {
    let blocks: Vec<usize> = cases.iter().map(|case| case.set).collect();
    let drawn = bootstrap(&blocks, RESAMPLINGS, SEED, |list| {
        statistic(&list.iter().map(|&i| cases[i]).collect::<Vec<_>>())
    });
    (statistic(cases), drawn.interval(0.95))
}

/// P(the number of a failure is larger than that of a success), ties counted half.
fn auc(cases: &[Case<'_>], number: usize) -> f64 {
    let of = |wanted: bool| {
        numbers(&chosen(cases, |case| case.succeeds[0] == wanted), |case| {
            case.numbers[number]
        })
    };
    f64::midpoint(1.0, cliffs_delta(&of(false), &of(true)))
}

fn rate(cases: &[Case<'_>]) -> f64 {
    numbers(cases, success).iter().sum::<f64>() / cases.len() as f64
}

/// A share in per cent, with its interval.
fn share(of: &[Case<'_>], counts: impl Fn(&Case<'_>) -> bool) -> String {
    let (count, all) = (
        of.iter().filter(|case| counts(case)).count() as f64,
        of.len() as f64,
    );
    let [low, high] = wilson(count, all).map(|end| 100.0 * end);
    if of.is_empty() {
        "–".to_owned()
    } else {
        format!(
            "{:.0} % of {all} [{low:.0}, {high:.0}]",
            100.0 * count / all
        )
    }
}

/// Writes the report into a folder.
pub(crate) fn write(driven: &[Driven<'_>], folder: &Path) -> Result<(), Failure> {
    let of_kind = |kind: Kind| -> Cases<'_> {
        let each = driven.iter().enumerate();
        let of_one = |(set, one)| {
            let one: &Driven<'_> = one;
            one.drives
                .iter()
                .filter(move |drive| drive.kind == kind)
                .map(move |drive| Case::new(set, one, *drive))
        };
        each.flat_map(of_one).collect()
    };
    let [edges, random] = [Kind::Relaxed, Kind::Random].map(of_kind);
    let main = chosen(&edges, |case| case.hold[0]);
    let moving = chosen(&main, Case::must_move);
    let mut text = tables(driven, &edges, &random, [&main, &moving])?;
    text += &failures(&moving)?;
    text += &by_contacts([&main, &moving])?;
    text.push_str("\n![Success by barrier](replayed_ways.png)\n\n![A success above a failure](replayed_ways_film.png)\n");
    fs::write(folder.join("replayed_ways.md"), text)?;
    fs::write(
        folder.join("replayed_ways.csv"),
        table(edges.iter().chain(&random)),
    )?;
    chart([&main, &moving])
        .draw()?
        .save(&folder.join("replayed_ways.png"))?;
    film(&moving, folder)
}

/// Ends at rest, success under each condition, the controls, the hypotheses, and success by barrier and length.
fn tables(
    driven: &[Driven<'_>],
    edges: &Cases<'_>,
    random: &Cases<'_>,
    [main, moving]: [&Cases<'_>; 2],
) -> Result<String, Failure> {
    let mut text = "# Are low passes ways that a hand can go?\n\nMade by `cargo run --release --example replayed_ways`; [the design](../docs/decisions/replay.md) \
        was fixed before. Intervals are of 95 %: Wilson's of shares, others by resampling edges within landscapes. *Must move*: the object must move or turn \
        so far in the hand that a hand that does nothing would fail.\n\n## Ends at rest\n\nEdges whose ends both hold, friction 0.6 without gravity.\n\n\
        | landscape | minima | edges | driven | ends hold | of these, must move | succeed | succeed, must move |\n|---|---|---|---|---|---|---|---|\n".to_owned();
    for (set, one) in driven.iter().enumerate() {
        let of = chosen(edges, |case| case.set == set);
        let held = chosen(&of, |case| case.hold[0]);
        let moved = chosen(&held, Case::must_move);
        let succeeds = |cases: &[Case<'_>]| share(cases, |case| case.succeeds[0]);
        writeln!(
            text,
            "| {} | {} | {} | {} | {} | {} | {} | {} |",
            one.set,
            one.files.minima.len(),
            one.files.edges.len(),
            of.len(),
            share(&of, |case| case.hold[0]),
            moved.len(),
            succeeds(&held),
            succeeds(&moved)
        )?;
    }
    text.push_str("\n## Success of relaxed ways\n\n| friction | gravity out of the palm, m/s² | ends hold | succeed | succeed, must move |\n|---|---|---|---|---|\n");
    for (condition, settings) in Replay::conditions().into_iter().enumerate() {
        let driven = chosen(edges, |case| {
            condition < case.drive.conditions(&case.driven.set)
        });
        let held = chosen(&driven, |case| case.hold[condition]);
        let succeeds = |cases: &[Case<'_>]| share(cases, |case| case.succeeds[condition]);
        writeln!(
            text,
            "| {} | {} | {} | {} | {} |",
            settings.friction,
            settings.gravity_m_s2[2],
            share(&driven, |case| case.hold[condition]),
            succeeds(&held),
            succeeds(&chosen(&held, Case::must_move))
        )?;
    }
    text.push_str("\n## Controls\n\nFriction 0.6 without gravity.\n\n| way | succeed | succeed, must move |\n|---|---|---|\n");
    let held = chosen(random, |case| case.hold[0]);
    let far = chosen(&held, Case::must_move);
    for (name, [all, moved], straight) in [
        ("relaxed", [main, moving], false),
        ("straight lines of the same edges", [main, moving], true),
        ("random pairs", [&held, &far], false),
    ] {
        let succeeds = |cases: &Cases<'_>| {
            share(cases, |case| {
                if straight {
                    case.straight
                } else {
                    case.succeeds[0]
                }
            })
        };
        writeln!(text, "| {name} | {} | {} |", succeeds(all), succeeds(moved))?;
    }
    for (title, cases) in [
        ("all ways", main),
        ("ways on which the object must move", moving),
    ] {
        write!(text, "\n## Hypotheses: {title}\n\n{}", hypotheses(cases))?;
    }
    text.push_str("\n## By barrier and length\n\nSuccess of relaxed ways, by quarters of the barrier and thirds of the length in each.\n\n| barrier up to | short | middle | long |\n|---|---|---|---|\n");
    for class in classes(main, BARRIER, 4) {
        let cells: Vec<String> = classes(&class, LENGTH, 3)
            .iter()
            .map(|cell| share(cell, |case| case.succeeds[0]))
            .collect();
        writeln!(
            text,
            "| {:.4} | {} |",
            class[class.len() - 1].numbers[BARRIER],
            cells.join(" | ")
        )?;
    }
    Ok(text)
}

/// How ways fail.
fn failures(moving: &Cases<'_>) -> Result<String, Failure> {
    let mut text = String::new();
    let missed = chosen(moving, |case| !case.succeeds[0]);
    let mut shares: Vec<f64> = numbers(&missed, |case| case.ending.1 / case.numbers[OBJECT_M]);
    shares.sort_by(f64::total_cmp);
    let ended = ["moved", "turned", "released", "overlap", "lost"].map(|name| {
        let count = chosen(&missed, |case| case.ending.0 == name).len();
        format!("{name} {count}")
    });
    writeln!(
        text,
        "\n## How ways fail\n\nOf {} failures where the object must move: {}. (*Moved* and *turned*: the object ended elsewhere in the hand; *released*: \
         it left the hand.) At the end, the object was off by a median of {:.2} times the distance that it had to go.",
        missed.len(),
        ended.join(", "),
        shares.get(shares.len() / 2).copied().unwrap_or(f64::NAN),
    )?;
    Ok(text)
}

/// Success by what the contacts do.
fn by_contacts(cases: [&Cases<'_>; 2]) -> Result<String, Failure> {
    let mut text = String::new();
    text.push_str(
        "\n## By what the contacts do\n\n| way | succeed | succeed, must move |\n|---|---|---|\n",
    );
    for name in ["sliding", "rolling", "regrasping", "letting go"] {
        let [all, moved] = cases.map(|cases| {
            share(&chosen(cases, |case| case.way == name), |case| {
                case.succeeds[0]
            })
        });
        writeln!(text, "| {name} | {all} | {moved} |")?;
    }
    Ok(text)
}

/// Success against the barrier.
fn chart([main, moving]: [&Cases<'_>; 2]) -> Chart {
    let line = |name: &str, cases: &Cases<'_>| {
        let point =
            |class: &Cases<'_>| [class[class.len() / 2].numbers[BARRIER], 100.0 * rate(class)];
        Series::line(classes(cases, BARRIER, 5).iter().map(point).collect()).named(name)
    };
    let x = Axis::linear("barrier (medians of fifths of the ways; 1 is letting go)");
    let y = Axis::linear("relaxed ways driven to their end (%)").with_range(0.0, 20.0);
    let panel = Panel::new(
        "",
        x,
        y,
        vec![line("all", main), line("object must move", moving)],
    );
    Chart {
        legend_below: true,
        ..Chart::new("", vec![panel])
    }
}

/// The tests of the design, each with its threshold.
fn hypotheses(cases: &[Case<'_>]) -> String {
    let of = |number: usize| move |cases: &[Case<'_>]| numbers(cases, |case| case.numbers[number]);
    let (barriers, lengths) = (of(BARRIER), of(LENGTH));
    let rho = interval(cases, &|cases| {
        spearman(&barriers(cases), &numbers(cases, success))
    });
    let area = interval(cases, &|cases| auc(cases, BARRIER));
    let given = interval(cases, &|cases| {
        partial_spearman(&barriers(cases), &numbers(cases, success), &lengths(cases))
    });
    let lead = interval(cases, &|cases| {
        let of = |name: &str| rate(&chosen(cases, |case| case.way == name));
        of("sliding") - of("regrasping")
    });
    let [wins, losses] = [true, false].map(|won| {
        chosen(cases, |case| {
            case.succeeds[0] == won && case.straight != won
        })
        .len()
    });
    let gain = (wins as f64 - losses as f64) / cases.len() as f64;
    let p = sign_test(wins, losses);
    let told = |(value, [low, high]): (f64, [f64; 2])| format!("{value:.2} [{low:.2}, {high:.2}]");
    let rows = [
        (
            "success falls with the barrier: ρ",
            told(rho),
            "at most −0.2, interval below 0",
            rho.0 <= -0.2 && rho.1[1] < 0.0,
        ),
        (
            "success falls with the barrier: AUC",
            told(area),
            "at least 0.6, interval above 0.5",
            area.0 >= 0.6 && area.1[0] > 0.5,
        ),
        (
            "given the length: partial ρ",
            told(given),
            "at most −0.1, interval below 0",
            given.0 <= -0.1 && given.1[1] < 0.0,
        ),
        (
            "relaxed beats straight",
            format!(
                "{:+.1} points ({wins} against {losses}, p = {p:.3})",
                100.0 * gain
            ),
            "at least +5 points, p < 0.05",
            gain >= 0.05 && p < 0.05,
        ),
        (
            "sliding minus regrasping",
            told(lead),
            "at least 0.1, interval above 0",
            lead.0 >= 0.1 && lead.1[0] > 0.0,
        ),
    ];
    let mut text = "| hypothesis | value | threshold | holds |\n|---|---|---|---|\n".to_owned();
    for (name, value, threshold, holds) in rows {
        let _ = writeln!(
            text,
            "| {name} | {value} | {threshold} | {} |",
            if holds { "**yes**" } else { "no" }
        );
    }
    let areas = (0..NUMBERS.len()).map(|number| {
        format!(
            "{} {}",
            NUMBERS[number],
            told(interval(cases, &|cases| auc(cases, number)))
        )
    });
    let areas: Vec<String> = areas.collect();
    let _ = writeln!(
        text,
        "\nAUC of each number for failure, without thresholds: {}.",
        areas.join(", ")
    );
    text
}

/// Cases in classes of equal size, by a number that rises.
fn classes<'a>(cases: &[Case<'a>], number: usize, count: usize) -> Vec<Cases<'a>> {
    let mut sorted = cases.to_vec();
    sorted.sort_by(|a, b| a.numbers[number].total_cmp(&b.numbers[number]));
    sorted
        .chunks(sorted.len().div_ceil(count).max(1))
        .map(<[_]>::to_vec)
        .collect()
}

/// The success on which the object moves farthest, and the failure with the lowest barrier.
fn film(cases: &[Case<'_>], folder: &Path) -> Result<(), Failure> {
    let [held, failed] =
        [true, false].map(|wanted| chosen(cases, |case| case.succeeds[0] == wanted));
    let by = |number: usize| {
        move |a: &Case<'_>, b: &Case<'_>| a.numbers[number].total_cmp(&b.numbers[number])
    };
    let shown = [
        held.into_iter().max_by(by(OBJECT_M)),
        failed.into_iter().min_by(by(BARRIER)),
    ];
    let mut pictures = Vec::new();
    for case in shown.into_iter().flatten() {
        println!("film: {} {}", case.driven.set, case.drive.key());
        pictures.extend(strip(case.driven, case.drive, 6)?);
    }
    let (images, captions): (Vec<_>, Vec<_>) = pictures.into_iter().unzip();
    Ok(contact_sheet(
        &images,
        &captions,
        6,
        &folder.join("replayed_ways_film.png"),
    )?)
}

fn table<'a>(cases: impl Iterator<Item = &'a Case<'a>>) -> String {
    let mut text = format!("set,kind,from,to,way,{}", NUMBERS.join(","));
    for what in ["ends hold", "succeeds"] {
        for settings in Replay::conditions() {
            let _ = write!(
                text,
                ",{what} at {} and {}",
                settings.friction, settings.gravity_m_s2[2]
            );
        }
    }
    text.push_str(",succeeds straight,ended,off_m\n");
    for case in cases {
        let [from, to] = case.drive.ends.map(|end| end.0);
        let kind = format!("{:?}", case.drive.kind).to_lowercase();
        let _ = write!(text, "{},{kind},{from},{to},{}", case.driven.set, case.way);
        for number in case.numbers {
            let _ = if number.is_nan() {
                write!(text, ",")
            } else {
                write!(text, ",{number:.6}")
            };
        }
        for flag in [&case.hold[..], &case.succeeds, &[case.straight]].concat() {
            let _ = write!(text, ",{}", u8::from(flag));
        }
        let (ended, off_m) = case.ending;
        let _ = writeln!(text, ",{ended},{off_m:.6}");
    }
    text
}
