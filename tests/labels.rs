//! Labels of grasps: properties for every hand and pose, and the command as a user runs it.
#![cfg(feature = "cli")]
#![expect(clippy::unwrap_used, reason = "helpers of tests are tests")]

use std::fs;
use std::path::PathBuf;
use std::process::Command;

use crate::desk::{Desk, assert_says};
use landscape::evaluation::taxonomy::{
    Anatomy, Bone, Labeller, NOT_APPLICABLE, Patch, Rule, Taxonomy, explain,
};
use landscape::hand::{Hand, HandFiles};
use landscape::mesh::Mesh;
use landscape::object::Object;
use landscape::space::Pose;
use landscape::store::{GraspFile, Overrides};

/// Every `step`-th grasp of the committed population.
fn some_grasps(step: usize) -> GraspFile {
    let (mut file, _) =
        GraspFile::read("data/grasps.parquet".as_ref(), Overrides::default()).unwrap();
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
            assert!((a.score - b.score).abs() < 1e-6, "{} {}", a.score, b.score);
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
    let hand = Hand::from_urdf(&crate::toy_hand::toy_hand(false), None).unwrap();
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

/// A hand without a thumb never gets a type that needs one.
#[test]
fn a_hand_without_a_thumb_does_no_thumb_grasps() {
    let file = some_grasps(4);
    let object = object_of(&file);
    let (human, thumbless) = (hand("human"), hand("human_thumbless"));
    let labeller = Labeller::new(&thumbless, &object, Rule::standard());
    assert!(labeller.applies());
    let feix = Taxonomy::feix();
    let mut listed = 0;
    for grasp in &file.grasps {
        let pose = &grasp.grasp.pose;
        let kept =
            |joint: &landscape::hand::Joint| pose.joints()[human.joint(&joint.name).unwrap()];
        let kept: Vec<f64> = thumbless.joints.iter().map(kept).collect();
        let x = Pose::new(
            std::array::from_fn(|k| pose[k]),
            pose.rotation_wxyz(),
            &kept,
        );
        for best in &labeller.label(&x).best {
            assert!(
                !feix.numbered(best.number).unwrap().uses(1),
                "type {}",
                best.number
            );
            listed += 1;
        }
    }
    assert!(listed > 0);
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
    let bare = Hand::from_urdf(&urdf.text, None).unwrap();
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
    let output = desk.run("label g.parquet");
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let said = String::from_utf8(output.stdout).unwrap();
    assert_says(
        &said,
        &[
            "by the rule",
            "unlisted",
            "known by cell only",
            "not applicable",
            "categories",
        ],
    );
    let read = |name: &str| {
        GraspFile::read(&desk.path(name), Overrides::default())
            .unwrap()
            .0
    };
    let labelled = read("g.labelled.parquet");
    assert_eq!(
        labelled.metadata.labels["rule"],
        Rule::standard().version.as_str()
    );
    for grasp in &labelled.grasps {
        assert!(grasp.label.is_none() && grasp.label_auto.is_some());
        assert_eq!(grasp.label_source.as_deref(), Some("rule"));
    }
    let again = fs::read(desk.path("g.labelled.parquet")).unwrap();
    assert!(desk.run("label g.parquet --threads 1").status.success());
    assert_eq!(fs::read(desk.path("g.labelled.parquet")).unwrap(), again);

    let id = file.grasps[0].id;
    let output = desk.run(&format!("label g.parquet --explain {id}"));
    let said = String::from_utf8(output.stdout).unwrap();
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

    let other = file.grasps[1].id;
    let csv = format!("id,label\n{id},thumb adducted\n{other},unlisted\n");
    fs::write(desk.path("labels.csv"), csv).unwrap();
    let output = desk.run("label g.parquet --from labels.csv");
    let said = String::from_utf8(output.stdout).unwrap();
    assert_says(
        &said,
        &["labelled by a human: 2", "human Adducted Thumb; rule"],
    );
    let labelled = read("g.labelled.parquet");
    assert_eq!(labelled.grasps[0].label.as_deref(), Some("Adducted Thumb"));
    assert_eq!(labelled.grasps[0].label_category.as_deref(), Some("power"));
    assert_eq!(labelled.grasps[0].label_source.as_deref(), Some("human"));
    assert_eq!(labelled.grasps[1].label.as_deref(), Some("unlisted"));
    assert_eq!(labelled.grasps[1].label_category, None);
    assert_eq!(labelled.grasps[2].label, None);
    // What a human said stays when the file is labelled again.
    assert!(
        desk.run("label g.labelled.parquet -o again.parquet")
            .status
            .success()
    );
    assert_eq!(read("again.parquet").grasps, labelled.grasps);

    let refused = |line: &str| desk.mistake(line);
    assert_says(
        &refused("label g.parquet --explain 123456"),
        &["no grasp with this id"],
    );
    fs::write(desk.path("bad.csv"), "id,label\n123456,Ring\n").unwrap();
    assert_says(
        &refused("label g.parquet --from bad.csv"),
        &["bad.csv", "line 2", "123456"],
    );
    fs::write(desk.path("bad.csv"), "id,label\n1,Rang\n").unwrap();
    assert_says(
        &refused("label g.parquet --from bad.csv"),
        &["line 2", "Rang"],
    );
    assert_says(&refused("label g.parquet --from none.csv"), &["none.csv"]);
    assert_says(&refused("label g.parquet -o none/x.parquet"), &["none"]);
}

/// A browser that runs without a window, if there is one.
fn browser() -> Option<PathBuf> {
    let folders = std::env::var_os("PATH")?;
    let names = ["chromium", "chromium-browser", "google-chrome", "chrome"];
    std::env::split_paths(&folders)
        .flat_map(|folder| names.map(|name| folder.join(name)))
        .find(|path| path.is_file())
}

/// Mouse and keyboard actions of a person, as events on the page. The file that would be saved is put into the page.
const PERSON: &str = r##"<script>
{
const press = (target, key) => target.dispatchEvent(new KeyboardEvent("keydown", { key, bubbles: true, cancelable: true }));
const type = text => { const search = document.getElementById("search"); search.value = text; search.dispatchEvent(new Event("input")); };
const told = [];
const all = document.querySelectorAll(".card");
const open = () => document.getElementById("chooser").open;
const focused = () => document.activeElement.dataset.id;
told.push(document.getElementById("progress").textContent);
all[1].click();                                          // the second card …
told.push("open " + open());
type("medium");
document.querySelector("#choices li").click();           // … by mouse
told.push("open " + open(), "at " + focused());
press(document.activeElement, "ArrowLeft");
press(document.activeElement, "ArrowLeft");
press(document.activeElement, "Enter");                  // the first by keyboard: number 14
type("14");
press(document.getElementById("search"), "Enter");
press(document.activeElement, "0");                      // the next without label: unlisted
told.push("at " + focused());
press(document.activeElement, "Enter");
type("prismatic 3");
press(document.getElementById("search"), "Enter");
all[3].focus();
press(document.activeElement, "Delete");                 // and back
told.push(document.getElementById("progress").textContent);
told.push("pictures " + [...document.images].filter(image => image.complete && image.naturalWidth > 100).length);
const make = URL.createObjectURL;
URL.createObjectURL = blob => {
  blob.text().then(text => {
    const result = document.createElement("pre");
    result.id = "result";
    result.textContent = told.join("\n") + "\n---\n" + text;
    document.body.append(result);
  });
  return make.call(URL, blob);
};
window.addEventListener("load", () => {
  told.push("pictures " + [...document.images].filter(image => image.complete && image.naturalWidth > 100).length);
  document.getElementById("download").click();
});
}
</script>"##;

/// Labels that contain the end tag of their element, and numbers beyond the precision of a script, are preserved.
#[test]
fn the_sheet_holds_any_label_and_any_number() {
    let desk = Desk::empty();
    let sheet = |change: &dyn Fn(&mut GraspFile)| {
        let mut file = some_grasps(60);
        file.grasps.truncate(4);
        change(&mut file);
        file.write(&desk.path("g.parquet")).unwrap();
        let said = desk.run("label g.parquet --sheet sheet.html");
        assert!(said.status.success(), "{said:?}");
        fs::read_to_string(desk.path("sheet.html")).unwrap()
    };
    let labels = ["<!--<script>", "</script><script>", "]]>", "--!>\u{2028}"];
    let ids = [(1 << 53) + 1, u64::MAX, (1 << 53) + 2, 7];
    let plain = sheet(&|_| {});
    let page = sheet(&|file| {
        for (grasp, (label, id)) in file.grasps.iter_mut().zip(labels.iter().zip(ids)) {
            grasp.label = Some((*label).to_owned());
            grasp.id = id;
        }
    });
    for markup in ["<!--", "<script", "</script"] {
        let [here, there] = [&page, &plain].map(|page| page.matches(markup).count());
        assert_eq!(here, there, "{markup}");
    }
    let data = page.split("type=\"application/json\">").nth(1).unwrap();
    let data = data.split("</script>").next().unwrap();
    let data: serde_json::Value = serde_json::from_str(data).unwrap();
    for (card, (label, id)) in
        (data["grasps"].as_array().unwrap().iter()).zip(labels.iter().zip(ids))
    {
        assert_eq!(card["human"], *label);
        // A text, for a number would be rounded.
        assert_eq!(card["id"], id.to_string());
    }
}

/// A person labels on the sheet in a real browser, and the file that it saves is read back.
#[test]
fn the_sheet_works_in_a_browser() {
    let desk = Desk::empty();
    let file = some_grasps(60);
    file.write(&desk.path("g.parquet")).unwrap();
    assert!(
        desk.run("label g.parquet --sheet sheet.html")
            .status
            .success()
    );
    let page = fs::read_to_string(desk.path("sheet.html")).unwrap();
    assert!(
        !page.contains("http://") && !page.contains("https://"),
        "needs nothing from elsewhere"
    );
    assert!(!page.contains("\"DATA\""));
    let Some(browser) = browser() else {
        println!("no browser on this machine (chromium or chrome): the page was not tried");
        return;
    };
    fs::write(
        desk.path("person.html"),
        page.replace("</body>", &format!("{PERSON}</body>")),
    )
    .unwrap();
    let output = Command::new(browser)
        .args([
            "--headless",
            "--no-sandbox",
            "--disable-gpu",
            "--virtual-time-budget=10000",
            "--dump-dom",
        ])
        .arg(format!(
            "--user-data-dir={}",
            desk.path("profile").display()
        ))
        .arg(format!("file://{}", desk.path("person.html").display()))
        .output()
        .unwrap();
    let page = String::from_utf8(output.stdout).unwrap();
    let result = page.split("<pre id=\"result\">").nth(1);
    let result = result
        .expect("the page ran to its end")
        .split("</pre>")
        .next()
        .unwrap();
    let (told, csv) = result.split_once("\n---\n").unwrap();
    let ids: Vec<u64> = file.grasps.iter().map(|grasp| grasp.id).collect();
    let expected = [
        format!("0 of {} labelled", ids.len()),
        "open true".to_owned(),
        "open false".to_owned(),
        format!("at {}", ids[2]),
        format!("at {}", ids[3]),
        format!("3 of {} labelled", ids.len()),
    ];
    let told: Vec<&str> = told.lines().collect();
    assert_eq!(told[..6], expected);
    assert_eq!(*told.last().unwrap(), format!("pictures {}", 2 * ids.len()));
    let expected = format!(
        "id,label\n{},Tripod\n{},Medium Wrap\n{},unlisted\n",
        ids[0], ids[1], ids[2]
    );
    assert_eq!(csv, expected);

    fs::write(desk.path("labels.csv"), csv).unwrap();
    assert!(
        desk.run("label g.parquet --from labels.csv")
            .status
            .success()
    );
    let (labelled, _) =
        GraspFile::read(&desk.path("g.labelled.parquet"), Overrides::default()).unwrap();
    let labels: Vec<Option<&str>> = labelled
        .grasps
        .iter()
        .take(4)
        .map(|grasp| grasp.label.as_deref())
        .collect();
    assert_eq!(
        labels,
        [Some("Tripod"), Some("Medium Wrap"), Some("unlisted"), None]
    );
}
