//! Planted sets: what is known of them must be found, and `docs/measures.md` shows what is not.

use std::fmt::Write;
use std::path::Path;

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use rand::RngExt;

use super::*;
use crate::evaluation::contact_regions;
use crate::evaluation::taxonomy::Rule;
use crate::grasp::{EnergySettings, Grasp, GraspEnergy, judge};
use crate::hand::Hand;
use crate::sample::{Task, stream};
use crate::space::{Pose, PoseSpace, Symmetry, joints_of_mut, object_from_hand, pose_coordinates};
use crate::store::{GraspFile, GraspRow, Overrides};
use crate::study::Run;
use crate::topography::Phase;

/// Number of grasps in each planted set of the page.
const GRASPS: usize = 12;

/// Planted sets of the two tables of the page, the varied one first.
const QUALITY: [&str; 4] = ["varied", "noise", "held off", "pressed in"];
const DIVERSITY: [&str; 5] = [
    "varied",
    "noise",
    "duplicates",
    "wide joints",
    "rotated copies",
];

/// Share of the value of the varied set that is as good as it.
const AS_GOOD: f64 = 0.9;

fn root(file: &str) -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(file)
}

/// Some grasps of the file of the project, and their energy on the object at its size, smaller and larger.
fn varied() -> ([GraspEnergy; 3], Vec<GraspRow>) {
    let (file, _) = GraspFile::read(&root("data/grasps.parquet"), Overrides::default()).unwrap();
    let population = file.landscapes().swap_remove(0);
    let hand = population.hand().unwrap();
    let energy = [1.0, 0.8, 1.2].map(|scale| {
        let object = population.object.build(scale).unwrap();
        GraspEnergy::new(hand.clone(), object, EnergySettings::default()).unwrap()
    });
    let step = population.grasps.len() / GRASPS;
    let rows = population.grasps.iter().step_by(step).take(GRASPS);
    (energy, rows.map(|row| (*row).clone()).collect())
}

/// The sets of [`DIVERSITY`], each of as many grasps. Those numbered `two` are copied, the first of them more than once.
fn planted(energy: &GraspEnergy, varied: &[GraspRow], two: [usize; 2]) -> [Vec<GraspRow>; 5] {
    let hand = energy.hand();
    let mut rng = stream(5, Task::Start, 0);
    let with = |row: &GraspRow, pose: Vec<f64>| GraspRow {
        grasp: Grasp::new(pose, row.grasp.contacts.clone()),
        ..row.clone()
    };
    let noise = varied.iter().map(|row| {
        let place = Vector3::from_fn(|_, _| rng.random_range(-0.1..0.1));
        let turn = Vector3::from_fn(|_, _| rng.random_range(-3.0..3.0));
        let joints = hand.joints.iter().map(|joint| {
            let [low, high] = joint.limits;
            rng.random_range(low..high)
        });
        let joints: Vec<f64> = joints.collect();
        with(row, pose_coordinates(&Isometry3::new(place, turn), &joints))
    });
    let noise = noise.collect();
    let duplicates = (0..varied.len()).map(|k| {
        let row = &varied[two[k % 2]];
        let mut pose = row.grasp.pose.to_vec();
        for q in joints_of_mut(&mut pose) {
            *q += rng.random_range(-0.02..0.02);
        }
        with(row, pose)
    });
    let duplicates = duplicates.collect();
    let one = &varied[two[0]];
    let wide = (0..varied.len()).map(|_| {
        let mut pose = one.grasp.pose.to_vec();
        for (q, joint) in joints_of_mut(&mut pose).iter_mut().zip(&hand.joints) {
            // Fingers open towards their lower limits.
            let share = rng.random_range(0.0..1.0);
            let digit = hand.digits[hand.links[joint.link.0].digit].as_str();
            if ["middle", "ring", "little"].contains(&digit) {
                *q += share * (joint.limits[0] - *q);
            }
        }
        with(one, pose)
    });
    let wide = wide.collect();
    let Symmetry::Axis { point, direction } = energy.pose_space().symmetry() else {
        panic!("the bottle has an axis");
    };
    let rotated = (0..varied.len()).map(|k| {
        let angle = std::f64::consts::TAU * k as f64 / varied.len() as f64;
        let turn = UnitQuaternion::new(direction * angle);
        let moved = Isometry3::from_parts(Translation3::from(point - turn * point), turn)
            * object_from_hand(&one.grasp.pose);
        with(one, pose_coordinates(&moved, one.grasp.pose.joints()))
    });
    [varied.to_vec(), noise, duplicates, wide, rotated.collect()]
}

/// The first grasp with a type, and the first of another type.
fn of_two_types(set: &MeasuredSet) -> [usize; 2] {
    let types = |place: usize| set.objects[0].grasps[place].type_name.as_ref();
    let mut typed = (0..GRASPS).filter(|place| types(*place).is_some());
    let one = typed.next().unwrap();
    let other = typed.find(|place| types(*place) != types(one)).unwrap();
    [one, other]
}

fn set_of(energy: &GraspEnergy, rows: &[GraspRow]) -> MeasuredSet {
    let rows: Vec<GraspRow> = (rows.iter().zip(0..))
        .map(|(row, id)| GraspRow { id, ..row.clone() })
        .collect();
    let rows: Vec<&GraspRow> = rows.iter().collect();
    let run = Run::default();
    let tally = run.tally(Phase::Judge, rows.len());
    MeasuredSet {
        objects: vec![MeasuredObject::of(energy, &rows, Rule::standard(), &tally)],
    }
}

fn values(set: &MeasuredSet) -> Vec<Option<f64>> {
    let without = Resampling {
        count: 0,
        ..Resampling::default()
    };
    let found = measure(set, None, &Measure::ALL, &without);
    found.iter().map(|found| found.value).collect()
}

/// Whether the measure calls a set that is worse than the varied one as good, or better.
fn misled(measure: Measure, value: f64, varied: f64) -> bool {
    match measure.better() {
        Better::More => value >= AS_GOOD * varied,
        Better::Less => value <= varied / AS_GOOD,
        Better::Neither => false,
    }
}

/// A table of the page: the measures from `first` on and before `end`.
fn table(names: &[&str], sets: &[&MeasuredSet], first: Measure, end: Option<Measure>) -> String {
    let mut text = format!(
        "| measure | {} |\n|---|{}\n",
        names.join(" | "),
        "---|".repeat(names.len())
    );
    let all: Vec<Vec<Option<f64>>> = sets.iter().map(|set| values(set)).collect();
    for (row, measure) in Measure::ALL.into_iter().enumerate() {
        if measure < first || end.is_some_and(|end| measure >= end) {
            continue;
        }
        let (factor, unit) = match measure.unit() {
            "m" => (1e3, ", mm"),
            "rad" => (1.0, ", rad"),
            "nats" => (1.0, ", nats"),
            _ => (1.0, ""),
        };
        let _ = write!(text, "| `{}`{unit} |", measure.name());
        for (column, values) in all.iter().enumerate() {
            let (Some(value), Some(varied)) = (values[row], all[0][row]) else {
                text += " – |";
                continue;
            };
            let shown = value * factor;
            let arrow = if column > 0 && misled(measure, value, varied) {
                " ↑"
            } else {
                ""
            };
            let digits = if shown < 0.995 && shown > 5e-4 { 3 } else { 2 };
            let _ = write!(text, " {shown:.digits$}{arrow} |");
        }
        text.push('\n');
    }
    text
}

/// The page shows these numbers. If they change, copy the tables of the message to the page, and read what it says.
#[test]
fn the_page_shows_where_each_measure_misleads() {
    let ([energy, smaller, larger], rows) = varied();
    let varied = set_of(&energy, &rows);
    let sets = planted(&energy, &rows, of_two_types(&varied));
    let [_, noise, duplicates, wide, rotated] = sets.map(|rows| set_of(&energy, &rows));
    let [off, pressed] = [smaller, larger].map(|energy| set_of(&energy, &rows));
    let first = Measure::JointDeviation;
    let quality = [&varied, &noise, &off, &pressed];
    let quality = table(&QUALITY, &quality, Measure::Epsilon, Some(first));
    let diversity = [&varied, &noise, &duplicates, &wide, &rotated];
    let shown = table(&DIVERSITY, &diversity, first, None);
    let page = std::fs::read_to_string(root("docs/measures.md")).unwrap_or_default();
    let found = page.contains(&quality) && page.contains(&shown);
    assert!(
        found,
        "docs/measures.md lacks one of these tables:\n{quality}\n{shown}"
    );

    // The facts of a grasp are those of the rest of the program.
    let facts = &varied.objects[0].grasps[0];
    let judgement = judge(&energy, &rows[0].grasp);
    assert_eq!(
        (facts.epsilon, facts.deepest_m),
        (judgement.epsilon, judgement.deepest_m)
    );
    for facts in varied
        .objects
        .iter()
        .chain(&wide.objects)
        .flat_map(|object| &object.grasps)
    {
        let regions = contact_regions(energy.hand(), energy.object(), &facts.pose);
        assert_eq!(facts.regions, Vec::from_iter(regions).join(", "));
        let touching = facts
            .regions
            .split(", ")
            .filter(|part| !["", "palm"].contains(part));
        assert_eq!(facts.digits_that_touch(), touching.count());
    }
}

/// Grasps of which only pose and kind matter, on an object with this symmetry.
fn poses(symmetry: Symmetry, poses: &[Vec<f64>]) -> MeasuredObject {
    let hand = std::sync::Arc::new(Hand::human());
    let grasps = poses.iter().enumerate().map(|(number, pose)| GraspFacts {
        id: number as u64,
        pose: Pose::from(pose.clone()),
        epsilon: 0.0,
        q1: 0.5,
        deepest_m: 0.0,
        object_in_hand_m: 0.001 * number as f64,
        digit_gaps_m: vec![-0.002, 0.004],
        links_in_contact: 2,
        regions: ["thumb", "thumb, index"][number % 2].to_owned(),
        type_name: None,
        cell: None,
        category: None,
    });
    MeasuredObject {
        name: "planted".to_owned(),
        scale: 1.0,
        space: PoseSpace::new(hand.pose_metric(), symmetry),
        inapplicable: None,
        grasps: grasps.collect(),
        hand,
    }
}

fn at(place: [f64; 3], turn: [f64; 3], joint: f64) -> Vec<f64> {
    let root = Isometry3::new(Vector3::from(place), Vector3::from(turn));
    let mut joints = Hand::human().prior.rest;
    joints[5] += joint;
    pose_coordinates(&root, &joints)
}

fn value(objects: &[MeasuredObject], measured: Measure) -> f64 {
    let set = MeasuredSet {
        objects: objects.to_vec(),
    };
    let found = measure(&set, None, &[measured], &Resampling::default());
    found[0].value.unwrap()
}

/// The faults of the published counts, one by one.
#[test]
fn unique_grasps_are_blind_as_published() {
    use Measure::{Distinct, UniqueMended, UniqueOrdered, UniquePublished};
    let start = at([0.0; 3], [0.0; 3], 0.0);
    // 3 cm further, turned by 90°, and with one joint bent by 0.05 rad.
    for (other, expected) in [
        (at([0.03, 0.0, 0.0], [0.0; 3], 0.0), [1.0, 2.0, 2.0, 2.0]),
        (at([0.0; 3], [1.57, 0.0, 0.0], 0.0), [1.0, 1.0, 2.0, 2.0]),
        (at([0.0; 3], [0.0; 3], 0.05), [2.0, 1.0, 1.0, 1.0]),
        (start.clone(), [1.0; 4]),
    ] {
        let object = poses(Symmetry::None, &[start.clone(), other]);
        let found = [UniquePublished, UniqueOrdered, UniqueMended, Distinct]
            .map(|measure| value(std::slice::from_ref(&object), measure));
        let equal = found
            .iter()
            .zip(&expected)
            .all(|(a, b)| (a - b).abs() < 1e-12);
        assert!(equal, "{found:?} {expected:?}");
    }
}

/// Grasps far apart count as their number, copies as one, and copies by the symmetry of the object too.
#[test]
fn the_vendi_score_is_a_number_of_grasps() {
    let far: Vec<Vec<f64>> = (0..7)
        .map(|k| at([0.3 * f64::from(k), 0.0, 0.0], [0.0; 3], 0.0))
        .collect();
    let apart = value(&[poses(Symmetry::None, &far)], Measure::Vendi);
    assert!((apart - 7.0).abs() < 1e-9, "{apart}");
    let doubled = [far.clone(), far.clone()].concat();
    let doubled = value(&[poses(Symmetry::None, &doubled)], Measure::Vendi);
    assert!((doubled - 7.0).abs() < 1e-9, "{doubled}");

    let centre = Vector3::new(0.01, 0.02, 0.0);
    let turned = |k: u32, axis: Vector3<f64>| {
        let turn = UnitQuaternion::new(axis * (0.7 * f64::from(k)));
        let start = Isometry3::translation(0.1, 0.0, 0.05);
        let about = Translation3::from(centre - turn * centre);
        pose_coordinates(
            &(Isometry3::from_parts(about, turn) * start),
            &Hand::human().prior.rest,
        )
    };
    let copies =
        |axis: Vector3<f64>| -> Vec<Vec<f64>> { (0..9).map(|k| turned(k, axis)).collect() };
    let upright = copies(Vector3::z());
    let plain = value(&[poses(Symmetry::None, &upright)], Measure::Vendi);
    assert!(plain > 6.0, "{plain}");
    let (point, direction) = (centre, Vector3::z() * 2.0);
    let around = value(
        &[poses(Symmetry::Axis { point, direction }, &upright)],
        Measure::Vendi,
    );
    assert!((around - 1.0).abs() < 1e-3, "{around}");
    let ball = poses(
        Symmetry::Sphere { centre },
        &copies(Vector3::new(0.5, -0.4, 0.9)),
    );
    let around = value(&[ball], Measure::Vendi);
    assert!((around - 1.0).abs() < 1e-9, "{around}");
    let half = Isometry3::from_parts(
        Translation3::identity(),
        UnitQuaternion::new(Vector3::z() * std::f64::consts::PI),
    );
    let start = at([0.1, 0.0, 0.0], [0.0; 3], 0.0);
    let joints = Pose::from(start.clone()).joints().to_vec();
    let copy = pose_coordinates(&(half * object_from_hand(&start)), &joints);
    let found = value(
        &[poses(Symmetry::Finite(vec![half]), &[start, copy])],
        Measure::Vendi,
    );
    assert!((found - 1.0).abs() < 1e-9, "{found}");
}

/// Values that follow from the definitions.
#[test]
fn definitions() {
    let rows: Vec<Vec<f64>> = (0..4)
        .map(|k| {
            at(
                [0.01 * f64::from(k), 0.0, 0.0],
                [0.3, -0.4, 0.5],
                0.1 * f64::from(k),
            )
        })
        .collect();
    let objects = [poses(Symmetry::None, &rows)];
    let of = |measure| value(&objects, measure);
    let joints = Hand::human().joints.len() as f64;
    // 0, 0.1, 0.2, 0.3: variance 0.0125 (÷ 4) and 0.0125 · 4/3 (÷ 3).
    assert!((of(Measure::JointDeviation) - 0.0125_f64.sqrt() / joints).abs() < 1e-12);
    let pooled = (0.0125_f64 * 4.0 / 3.0).sqrt() * 1.1 / (joints + 6.0);
    assert!((of(Measure::PooledDeviation) - pooled).abs() < 1e-12);
    assert!((of(Measure::Pca) - 1.0).abs() < 1e-9);
    // x takes four bins of 6.25 mm but for those of 0 and 0.01: 16, 17, 19, 20.
    assert!((of(Measure::PositionEntropy) - libm::log(4.0) / 3.0).abs() < 1e-12);
    assert!(of(Measure::OrientationEntropy).abs() < 1e-12);
    assert!((of(Measure::Regions) - 2.0).abs() < 1e-12);
    // (0 + 4)/2 and 4 + 2 mm.
    assert!((of(Measure::ContactDistance) - 0.002).abs() < 1e-12);
    assert!((of(Measure::ContactConsistency) - 0.006).abs() < 1e-12);
    let mut deep = objects[0].clone();
    deep.grasps[3].object_in_hand_m = 0.005;
    assert!((value(&[deep], Measure::ValidQ1) - 0.375).abs() < 1e-12);
    // What lies outside the box is dropped, and the mean is over x, y and z.
    let outside = poses(
        Symmetry::None,
        &[at([0.2, 0.0, 0.0], [0.0; 3], 0.0), rows[0].clone()],
    );
    assert!(value(&[outside], Measure::PositionEntropy).abs() < 1e-12);
}

/// Which grasps and objects count, and what is said if none does.
#[test]
fn grasps_that_do_not_hold_do_not_count() {
    let apart = |from: u64| -> MeasuredObject {
        let rows: Vec<Vec<f64>> = (0..6)
            .map(|k| at([0.1 * f64::from(k), 0.0, 0.0], [0.0; 3], 0.0))
            .collect();
        let mut object = poses(Symmetry::None, &rows);
        object
            .grasps
            .iter_mut()
            .zip(from..)
            .for_each(|(facts, id)| facts.id = id);
        object
    };
    let set = MeasuredSet {
        objects: vec![apart(0), apart(6)],
    };
    let held: BTreeSet<u64> = [1, 2, 4].into();
    let of = |held: Option<&BTreeSet<u64>>, measured, at| {
        let resampling = Resampling {
            at,
            ..Resampling::default()
        };
        measure(&set, held, &[measured], &resampling).remove(0)
    };
    // Three on one object and none on the other.
    let found = of(Some(&held), Measure::Distinct, None);
    assert_eq!(
        (found.value, found.grasps, found.objects, found.of_held),
        (Some(1.5), 3, 2, true)
    );
    let [low, high] = found.interval.unwrap();
    assert!(
        low < 0.5 && high > 2.5,
        "{low} {high}: objects are drawn too"
    );
    let found = of(Some(&held), Measure::Vendi, None);
    assert_eq!((found.grasps, found.objects), (3, 1));
    assert!((found.value.unwrap() - 3.0).abs() < 1e-6);
    let found = of(Some(&held), Measure::Q1, None);
    assert_eq!((found.grasps, found.of_held), (12, false));
    let found = of(None, Measure::Distinct, Some(4));
    assert_eq!(
        (found.value, found.grasps, found.of_held),
        (Some(4.0), 8, false)
    );
    let none = of(Some(&BTreeSet::new()), Measure::Vendi, None);
    assert_eq!(
        (none.value, none.reason.as_deref()),
        (None, Some("no grasp holds"))
    );
    let none = of(Some(&held), Measure::Distinct, Some(4));
    assert_eq!(
        none.reason.as_deref(),
        Some("no object has 4 grasps that hold")
    );
    let none = of(None, Measure::Types, None);
    assert_eq!(
        (none.value, none.reason.as_deref()),
        (None, Some("no grasp has a type"))
    );
}

#[test]
fn the_number_of_threads_changes_nothing() {
    let mut rng = stream(3, Task::Start, 0);
    let mut rows = || -> Vec<Vec<f64>> {
        let mut number = || rng.random_range(-0.1..0.1);
        (0..20)
            .map(|_| at([number(), number(), number()], [0.0; 3], number()))
            .collect()
    };
    let set = MeasuredSet {
        objects: vec![
            poses(Symmetry::None, &rows()),
            poses(Symmetry::None, &rows()),
        ],
    };
    let resampling = Resampling {
        count: 20,
        seed: 4,
        at: Some(10),
    };
    let found = |threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| format!("{:?}", measure(&set, None, &Measure::ALL, &resampling)))
    };
    assert_eq!(found(1), found(3));
}

#[test]
fn names_are_different() {
    let names: BTreeSet<&str> = Measure::ALL.iter().map(|measure| measure.name()).collect();
    assert_eq!(names.len(), Measure::ALL.len());
    assert!(
        Measure::ALL
            .iter()
            .all(|measure| Measure::named(measure.name()) == Some(*measure))
    );
    assert!(
        Measure::ALL.is_sorted(),
        "the order of tables is that of the enum"
    );
}
