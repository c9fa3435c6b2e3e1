//! Labels of grasps: properties for every hand and pose, and the command as a user runs it.
#![cfg(feature = "cli")]
#![expect(clippy::unwrap_used, reason = "helpers of tests are tests")]

use crate::described::described;
use crate::desk::{Desk, assert_says};
use landscape::evaluation::taxonomy::{
    Anatomy, Bone, Label, Labeller, NOT_APPLICABLE, Patch, Rule, Taught, Taxonomy, Unlike, explain,
};
use landscape::hand::{Hand, HandFiles};
use landscape::mesh::Mesh;
use landscape::object::Object;
use landscape::store::{GraspFile, GraspRow, Overrides, content_hash};

/// Every `step`-th grasp of the committed population.
fn some_grasps(step: usize) -> GraspFile {
    some_of("data/grasps.parquet", step)
}

/// Every `step`-th grasp of a file.
fn some_of(path: &str, step: usize) -> GraspFile {
    let (mut file, _) = GraspFile::read(path.as_ref(), Overrides::default()).unwrap();
    let mut row = 0;
    file.grasps.retain(|_| {
        row += 1;
        row % step == 1
    });
    file
}

fn hand(name: &str) -> Hand {
    Hand::from_files(&HandFiles::named(name).unwrap()).unwrap()
}

fn object_of(file: &GraspFile) -> std::sync::Arc<Object> {
    file.metadata.objects[0].build(1.0).unwrap()
}

/// The mirror image of an object at x = 0.
fn mirrored(object: &Object) -> Object {
    let vertices = object.mesh.vertices().iter();
    let vertices = vertices
        .map(|v| nalgebra::Vector3::new(-v.x, v.y, v.z))
        .collect();
    let triangles = object
        .mesh
        .triangles()
        .iter()
        .map(|&[a, b, c]| [a, c, b])
        .collect();
    let mesh = Mesh::new("mirrored", vertices, triangles).unwrap();
    let mut mirrored = Object::from_mesh("mirrored", mesh, &object.description).unwrap();
    mirrored.surface_samples.clone_from(&object.surface_samples);
    for sample in &mut mirrored.surface_samples {
        sample.point.x = -sample.point.x;
        sample.normal.x = -sample.normal.x;
    }
    mirrored
}

/// A left hand on the mirror image of an object: x ↦ −x turns the quaternion (w, x, y, z) into (w, x, −y, −z).
#[test]
fn a_mirrored_grasp_has_the_same_label() {
    let file = some_grasps(12);
    let object = object_of(&file);
    let (right, other) = (hand("human"), mirrored(&object));
    let left = right.mirrored();
    let (labeller, mirror) = (
        Labeller::new(&right, &object, Rule::standard()),
        Labeller::new(&left, &other, Rule::standard()),
    );
    let mut texts = std::collections::BTreeSet::new();
    for grasp in &file.grasps {
        let x = grasp.grasp.pose.to_vec();
        let mut turned = x.clone();
        for coordinate in [0, 5, 6] {
            turned[coordinate] = -turned[coordinate];
        }
        let (one, two) = (labeller.label(&x), mirror.label(&turned));
        assert_eq!(one.verdict, two.verdict, "grasp {}", grasp.id);
        assert_eq!(one.virtual_fingers, two.virtual_fingers);
        for (a, b) in one.best.iter().zip(&two.best) {
            assert_eq!(a.number, b.number);
            // Fields are baked with single precision, and a pose is corrected by an iteration.
            assert!((a.score - b.score).abs() < 1e-5, "{} {}", a.score, b.score);
        }
        assert_eq!(one, labeller.label(&x), "the same twice");
        texts.insert(one.text());
    }
    assert!(texts.len() >= 2, "{texts:?}");
}

#[test]
fn hands_unlike_a_human_one_are_not_guessed() {
    let ball = Object::named("ball").unwrap();
    for name in ["gripper_parallel", "gripper_three_finger"] {
        let hand = hand(name);
        let labeller = Labeller::new(&hand, &ball, Rule::standard());
        assert!(!labeller.applies(), "{name}");
        let label = labeller.label(&hand.rest_coordinates());
        assert_eq!(label.text(), NOT_APPLICABLE);
        assert!(label.best.is_empty());
        let why = explain(&label, Rule::standard());
        assert!(
            why.contains("a thumb") && !why.contains("fewer than two parts"),
            "{why}"
        );
    }
    // A human hand that touches nothing has no label either.
    let human = hand("human");
    let mut far = human.rest_coordinates();
    far[0] = 1.0;
    let label = Labeller::new(&human, &ball, Rule::standard()).label(&far);
    assert_eq!(label.text(), NOT_APPLICABLE);
    let why = explain(&label, Rule::standard());
    assert!(
        why.contains("fewer than two parts") && !why.contains("a thumb"),
        "{why}"
    );
}

/// Earlier versions did not recognise fingers of two phalanges, such as those of the Inspire and the Ability hand.
#[test]
fn fingers_of_two_phalanges_are_fingers() {
    // On the Schunk SVH hand a moving half palm carries the ring and the little finger, which are two fingers all the same.
    let half_palm = described(&crate::toy_hand::toy_hand(true), None).unwrap();
    let anatomy = Anatomy::of(&half_palm).unwrap();
    assert!((1..=5).all(|digit| anatomy.has(digit)));
    let hand = described(&crate::toy_hand::toy_hand(false), None).unwrap();
    let anatomy = Anatomy::of(&hand).unwrap();
    assert!((1..=5).all(|digit| anatomy.has(digit)));
    for (digit, name) in [(2, "index"), (5, "little")] {
        for (link, bone) in [(1, Bone::Proximal), (2, Bone::Distal)] {
            let link = format!("{name}_{link}");
            let points = (0..hand.surface.len())
                .filter(|&i| hand.links[hand.surface[i].link.0].name == link);
            let patches: Vec<Patch> = points.map(|i| anatomy.patch(i)).collect();
            assert!(!patches.is_empty());
            let of_bone =
                |patch: &Patch| matches!(patch, Patch::Digit(d, b, _) if (*d, *b) == (digit, bone));
            assert!(patches.iter().all(of_bone), "{link}: {patches:?}");
        }
    }
    // Closed about a ball it has a label.
    let ball = Object::named("ball").unwrap();
    let labeller = Labeller::new(&hand, &ball, Rule::standard());
    let mut x = hand.rest_coordinates();
    x[..3].copy_from_slice(&[0.0, 0.0, -0.047]);
    x[7..].fill(0.7);
    let label = labeller.label(&x);
    assert_ne!(label.text(), NOT_APPLICABLE);
    assert!(!label.best.is_empty());
}

/// The same files without the side file.
fn without_side_file(files: &HandFiles) -> HandFiles {
    let is_json = |name: &str| {
        std::path::Path::new(name)
            .extension()
            .is_some_and(|end| end == "json")
    };
    let kept = files.files.iter().filter(|file| !is_json(&file.name));
    HandFiles {
        files: kept.cloned().collect(),
    }
}

/// Published hands of the test data, without any side file: those that are built like a human hand are read as one, whatever
/// their number of phalanges, coupled joints or names; of the others the failed condition is told.
#[test]
fn published_hands_are_read_as_human_or_told_why_not() {
    let Some(data) = std::env::var_os("LANDSCAPE_TEST_DATA") else {
        return;
    };
    let data = std::path::Path::new(&data);
    let expected = [
        (
            "hands/dex_urdf/inspire_hand/inspire_hand_right.urdf",
            Ok([2, 5]),
        ),
        (
            "hands/dex_urdf/shadow_hand/shadow_hand_right.urdf",
            Ok([3, 5]),
        ),
        (
            "hands/dex_urdf/allegro_hand/allegro_hand_right.urdf",
            Ok([3, 4]),
        ),
        (
            "hands/shadow_dexonomy/shadow_right_primitives.xml",
            Ok([3, 5]),
        ),
        ("hands/mano/mano_right.xml", Ok([3, 5])),
        ("ycb_affordance/hand/mano_ycba.xml", Ok([3, 5])),
        (
            "hands/dex_urdf/barrett_hand/bhand_model.urdf",
            Err(Unlike::Fingers(2)),
        ),
        (
            "hands/dex_urdf/dclaw_gripper/dclaw_gripper.urdf",
            Err(Unlike::NoThumb),
        ),
    ];
    for (path, expected) in expected {
        let files = HandFiles::load(&data.join(path)).unwrap();
        // The MANO-like hand has a side file beside it, which it must not need.
        let bare = without_side_file(&files);
        let hand = Hand::from_files(&bare).unwrap();
        match (Anatomy::of(&hand), expected) {
            (Ok(anatomy), Ok([phalanges, digits])) => {
                for digit in 1..=digits {
                    assert!(anatomy.has(digit), "{path}: {digit}");
                }
                let bones = [Bone::Proximal, Bone::Middle, Bone::Distal];
                let posed = hand.straight();
                let index = bones.map(|bone| anatomy.direction(&posed, 2, bone).is_some());
                let found = index.into_iter().filter(|known| *known).count();
                assert_eq!(found, phalanges, "{path}");
            }
            (found, expected) => assert_eq!(found.err(), expected.err(), "{path}"),
        }
    }
}

/// Without its side file the human hand is interpreted from its joints and geometry alone; the result agrees with the
/// side file.
#[test]
fn anatomy_is_derived_as_tagged() {
    let files = HandFiles::named("human").unwrap();
    let urdf = files
        .files
        .iter()
        .find(|file| file.name.contains(".urdf"))
        .unwrap();
    let bare = described(&urdf.text, None).unwrap();
    let derived = Anatomy::of(&bare).expect("a human hand is read as one");
    let human = hand("human");
    let tagged = Anatomy::of(&human).unwrap();
    let (mut same, mut digits) = (0, 0);
    for (i, point) in bare.surface.iter().enumerate() {
        let name = &bare.links[point.link.0].name;
        let Some(expected) = tagged.patch_on(&human, human.link(name).unwrap(), &point.normal)
        else {
            continue;
        };
        same += usize::from(derived.patch(i) == expected);
        let digit = |patch| match patch {
            Patch::Palm(_) => 0,
            Patch::Digit(digit, ..) => digit,
        };
        digits += usize::from(digit(derived.patch(i)) == digit(expected));
    }
    let count = bare.surface.len();
    assert_eq!(digits, count);
    // Sides near a border of two may differ: a normal is compared with the nearest one of another sample.
    assert!(same * 100 >= count * 88, "{same} of {count}");
}

#[test]
fn labels_are_written_explained_and_overridden() {
    let desk = Desk::empty();
    let file = some_grasps(40);
    file.write(&desk.path("g.parquet")).unwrap();
    let said = desk.print("label g.parquet");
    assert_says(
        &said,
        &[
            "verdicts",
            "unlisted",
            "of one type",
            "not applicable",
            "categories",
        ],
    );
    let read = |name: &str| desk.grasps(name);
    let labelled = read("g.labelled.parquet");
    assert_eq!(
        labelled.metadata.labels["rule"],
        Rule::standard().version.as_str()
    );
    for grasp in &labelled.grasps {
        assert!(grasp.label.is_none() && grasp.label_auto.is_some());
        assert_eq!(grasp.label_source.as_deref(), Some("rule"));
    }
    let again = desk.bytes("g.labelled.parquet");
    desk.succeed("label g.parquet --threads 1");
    assert_eq!(desk.bytes("g.labelled.parquet"), again);

    let id = file.grasps[0].id;
    let said = desk.print(&format!("label g.parquet --explain {id}"));
    assert_says(
        &said,
        &[
            "opposition",
            "virtual fingers",
            "for it",
            "category",
            "what is held",
            "outcome",
            "rule  ",
        ],
    );
    let first = &labelled.grasps[0];
    let best = first.label_best.as_deref().unwrap();
    let (answer, certainty) = best.split_once(" (").unwrap();
    assert!(Taxonomy::feix().named(answer).is_some(), "{best}");
    let certainty = certainty.split_once(')').unwrap().0;
    assert!(["likely", "open", "a guess"].contains(&certainty), "{best}");
    assert_says(&said, &[answer, &format!("), {certainty}")]);

    let other = file.grasps[1].id;
    let csv = format!("id,label\n{id},thumb adducted\n{other},unlisted\n");
    desk.write("labels.csv", csv);
    let said = desk.print("label g.parquet --from labels.csv");
    assert_says(&said, &["agreeing", "disagreeing", "Adducted Thumb"]);
    let labelled = read("g.labelled.parquet");
    assert_eq!(labelled.grasps[0].label.as_deref(), Some("Adducted Thumb"));
    assert_eq!(labelled.grasps[0].label_category.as_deref(), Some("power"));
    assert_eq!(labelled.grasps[0].label_source.as_deref(), Some("human"));
    assert_eq!(labelled.grasps[1].label.as_deref(), Some("unlisted"));
    assert_eq!(labelled.grasps[1].label_category, None);
    assert_eq!(labelled.grasps[2].label, None);
    // What a human said stays when the file is labelled again.
    desk.succeed("label g.labelled.parquet -o again.parquet");
    assert_eq!(read("again.parquet").grasps, labelled.grasps);

    let refused = |line: &str| desk.mistake(line);
    assert_says(
        &refused("label g.parquet --explain 123456"),
        &["no grasp with this id"],
    );
    desk.write("bad.csv", "id,label\n123456,Ring\n");
    assert_says(
        &refused("label g.parquet --from bad.csv"),
        &["bad.csv", "line 2", "123456"],
    );
    desk.write("bad.csv", "id,label\n1,Rang\n");
    assert_says(
        &refused("label g.parquet --from bad.csv"),
        &["line 2", "Rang"],
    );
    assert_says(&refused("label g.parquet --from none.csv"), &["none.csv"]);
    assert_says(&refused("label g.parquet -o none/x.parquet"), &["none"]);
}

/// A file of grasps of one object, in which a person has named each grasp as the rule does, if it does.
fn named_grasps(path: &str) -> GraspFile {
    let mut file = some_of(path, 20);
    let (hand, object) = (hand("human"), object_of(&file));
    let labeller = Labeller::new(&hand, &object, Rule::standard());
    for grasp in &mut file.grasps {
        let Label { best, .. } = labeller.label(&grasp.grasp.pose);
        let entry = best
            .first()
            .and_then(|best| Taxonomy::feix().numbered(best.number));
        grasp.label = entry.map(|entry| entry.name.clone());
    }
    file
}

/// A desk with the grasps of two objects, `a.parquet` and `b.parquet`, that a person named, and how many these are.
fn desk_of_a_teacher() -> (Desk, usize) {
    let desk = Desk::empty();
    let mut count = 0;
    for (name, path) in [
        ("a.parquet", "data/grasps.parquet"),
        ("b.parquet", "data/experiments/ellipsoid.parquet"),
    ] {
        let file = named_grasps(path);
        count += file
            .grasps
            .iter()
            .filter(|grasp| grasp.label.is_some())
            .count();
        file.write(&desk.path(name)).unwrap();
    }
    (desk, count)
}

/// Somebody teaches a labeller with grasps of two objects, and lets it name the same grasps, of which no label is left.
#[test]
fn a_labeller_is_taught_and_names_grasps() {
    let (desk, count) = desk_of_a_teacher();
    let told =
        desk.document("label --learn a.parquet b.parquet -o my.labeller -q --json --threads 1");
    assert_eq!(told["tested_on_left_out"], "grasps", "of two objects");
    let labels = told["labels"].as_object().unwrap().values();
    assert_eq!(
        labels.map(|n| n.as_u64().unwrap()).sum::<u64>(),
        count as u64
    );
    for judged in told["judged"].as_array().unwrap() {
        // The labels are the rule's, which is therefore always right.
        assert_eq!(judged["rule_share"], 1.0, "{judged}");
        assert!(
            judged["labeller_share"].as_f64() > judged["commonest_share"].as_f64(),
            "{judged}"
        );
    }
    let text = desk.text("my.labeller");
    let taught = Taught::parse(&text).unwrap();
    assert_eq!((taught.count(), taught.text()), (count, text));
    let with: Vec<_> = (taught.taught_with.iter())
        .map(|with| {
            (
                with.file.as_str(),
                with.objects.join(" "),
                with.hands.join(" "),
            )
        })
        .collect();
    let with_of = |file, object: &str| (file, object.to_owned(), "human".to_owned());
    assert_eq!(
        with,
        [
            with_of("a.parquet", "bottle_round"),
            with_of("b.parquet", "ellipsoid")
        ]
    );

    // The text has what a person needs to judge it, and the file may be replaced.
    let (told, said) = desk.both("label --learn a.parquet b.parquet -o my.labeller --threads 2");
    let titles =
        "judged | labeller (%) | rule (%) | labeller less rule (%) | certainties | right (%)";
    assert_says(&told, &titles.split(" | ").collect::<Vec<_>>());
    assert_says(
        &said,
        &[
            "it is not shown that the labeller names",
            "better than the rule",
        ],
    );
    assert_eq!(desk.text("my.labeller"), taught.text(), "on two threads");

    let mut bare = desk.grasps("a.parquet");
    bare.grasps.iter_mut().for_each(|grasp| grasp.label = None);
    bare.write(&desk.path("bare.parquet")).unwrap();
    let told = desk.document("label bare.parquet --by my.labeller -q --json --threads 1");
    let labelled = desk.grasps("bare.labelled.parquet");
    let source = |grasp: &&GraspRow| grasp.label_source.as_deref() == Some("labeller");
    let named = labelled.grasps.iter().filter(source).count();
    let left = told["left_to_the_rule"].as_u64().unwrap_or(0);
    assert!(
        named >= 2 * labelled.grasps.len() / 3,
        "it has seen these grasps: {named}, {left}"
    );
    let left = usize::try_from(left).unwrap();
    assert_eq!(named + left, labelled.grasps.len());
    let labels = &labelled.metadata.labels;
    assert_eq!(labels["labeller"]["labels"], count);
    assert_eq!(
        labels["labeller"]["content_hash"],
        content_hash(&[&desk.bytes("my.labeller")]).as_str()
    );
    assert!(labelled.metadata.command.ends_with("--by my.labeller"));
    let again = desk.bytes("bare.labelled.parquet");
    desk.succeed("label bare.parquet --by my.labeller -q --threads 2");
    assert!(
        desk.bytes("bare.labelled.parquet") == again,
        "on two threads"
    );
    // The labeller names what it has seen as the person did.
    let told = desk.document("label a.parquet --by my.labeller -q --json");
    let [agreeing, disagreeing] =
        ["agreeing", "disagreeing"].map(|key| told[key].as_u64().unwrap());
    assert!(agreeing > 2 * disagreeing, "{agreeing}, {disagreeing}");

    let first = labelled.grasps.iter().find(source).unwrap();
    let said = desk.print(&format!(
        "label bare.parquet --by my.labeller --explain {}",
        first.id
    ));
    let labels = format!("taught with {count} labels");
    assert_says(
        &said,
        &[
            "labeller",
            &labels,
            "by the rule",
            "1 opposition",
            first.label_auto.as_deref().unwrap(),
        ],
    );
    desk.succeed("report bare.parquet --by my.labeller -q");
}

#[test]
fn labellers_that_cannot_be_taught_or_used_are_refused() {
    let (desk, count) = desk_of_a_teacher();
    // Ids of one file may be those of another.
    let file = desk.grasps("a.parquet");
    let shared = desk.grasps("b.parquet").grasps[0].id;
    assert_eq!(file.grasps[0].id, shared);
    desk.write("labels.csv", format!("id,label\n{shared},Ring\n"));
    let refused = |line: &str, words: &[&str]| assert_says(&desk.mistake(line), words);
    refused(
        "label --learn a.parquet b.parquet --from labels.csv",
        &[
            "labels.csv, line 2",
            &format!("several grasps have the id {shared}"),
            "--from",
        ],
    );
    let mut few = file.clone();
    few.grasps.truncate(6);
    few.write(&desk.path("few.parquet")).unwrap();
    refused(
        "label --learn few.parquet -q",
        &["6 grasps", "at least 30 are needed"],
    );
    assert!(!desk.path("few.labeller").exists());
    // A table gives the labels in place of the file.
    let rows = file.grasps[..6]
        .iter()
        .map(|grasp| format!("{},\n", grasp.id));
    let csv = format!("id,label\n{}", rows.collect::<String>());
    desk.write("none.csv", csv);
    refused(
        "label --learn few.parquet --from none.csv -q",
        &["0 grasps"],
    );

    desk.succeed("label --learn a.parquet b.parquet -q");
    let text = desk.text("a.labeller");
    assert_eq!(Taught::parse(&text).unwrap().count(), count);
    let rule = include_str!("../data/taxonomy/rule.toml");
    let other = rule.replace("cell_share = 0.4", "cell_share = 0.41");
    assert_ne!(rule, other);
    desk.write("other.toml", other);
    refused(
        "label few.parquet --by a.labeller --rule other.toml",
        &[
            "a.labeller",
            "another version of the rule",
            "teach it again",
        ],
    );
    desk.write("torn.labeller", &text[..text.len() / 2]);
    refused(
        "label few.parquet --by torn.labeller",
        &["torn.labeller", "not a labeller", "at line"],
    );
    refused("report few.parquet --by few.parquet", &["few.parquet"]);
    refused(
        "label few.parquet --by none.labeller",
        &["--by: cannot read none.labeller"],
    );
    refused("label a.parquet b.parquet", &["several files", "--learn"]);
    // A file of somebody else stays.
    desk.write("mine.labeller", "years of work");
    refused(
        "label --learn a.parquet b.parquet -o mine.labeller",
        &["mine.labeller", "--force"],
    );
}
