//! All readers of files with valid files, for the mutations of `main.rs` and for the coverage-guided fuzzer in `guided`.

#[path = "../../pickled/mod.rs"]
mod pickled;
pub(crate) mod samples;

use std::fs::{self, File};
use std::path::Path;
use std::sync::OnceLock;

use bytes::Bytes;
use landscape::evaluation::stability::Protocol;
use landscape::evaluation::taxonomy::{Rule, Taught};
use landscape::formats::toml_text;
use landscape::grasp::EnergySettings;
use landscape::grasp::synthesis::SynthesisSettings;
use landscape::hand::{Hand, HandError, HandFiles, PosedHand};
use landscape::mesh::Mesh;
use landscape::object::neural::{Specs, Tensors};
use landscape::object::{Assembly, Description};
use landscape::store::exchange::{self, JointColumns, Mapping};
use landscape::store::{
    GraspFile, Journal, LandscapeFiles, Overrides, StationaryRow, content_hash, read_attempts,
};
use landscape::study::NetworkOfStates;
use landscape::topography::exchange::{Database, points, points_of_text, read_points};
use landscape::topography::{Evidence, FamilySettings, Tree};
use parquet::arrow::ArrowWriter;
use parquet::arrow::arrow_reader::ParquetRecordBatchReader;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use samples::{
    DAE, EXCHANGE, GLTF, INPUT_HASH, ISAAC, MAPPING, MJCF, OBJ, OWN_KEY, PLY, POINTS, PROTOCOL,
    ROWS, SHAPES, SIDE, STL, TABLE, TRANSFORMS, URDF, binary_ply, binary_stl, bytes, checkpoint,
    described, example, gltf, joints, journal, labeller, landscape, landscape_folder, msh, npz,
    parquet, pickles, tensors, text,
};
use serde::Deserialize;
use serde::de::DeserializeOwned;
use zip::CompressionMethod;

/// A reader: it returns its error on some bytes, if there is one. The folder is for readers of files.
pub(crate) type Read = fn(&[u8], &Path) -> Result<(), String>;

/// Names, valid files and readers. A new reader needs one line here.
#[expect(clippy::too_many_lines, reason = "it is a table")]
pub(crate) fn readers() -> Vec<(&'static str, Vec<Vec<u8>>, Read)> {
    vec![
        (
            "urdf",
            vec![text(URDF), bytes("data/hands/human/human.urdf")],
            hand,
        ),
        ("mjcf", vec![text(MJCF), text(URDF)], hand),
        (
            "side_file",
            vec![text(SIDE), bytes("data/hands/human/human.json")],
            side,
        ),
        ("hand_obj", vec![text(OBJ)], |bytes, folder| {
            hand_mesh("obj", bytes, folder)
        }),
        (
            "hand_stl",
            vec![text(STL), binary_stl()],
            |bytes, folder| hand_mesh("stl", bytes, folder),
        ),
        ("hand_msh", vec![msh()], |bytes, folder| {
            hand_mesh("msh", bytes, folder)
        }),
        ("hand_dae", vec![text(DAE)], |bytes, folder| {
            hand_mesh("dae", bytes, folder)
        }),
        ("hand_glb", vec![gltf().1], |bytes, folder| {
            hand_mesh("glb", bytes, folder)
        }),
        ("object_obj", vec![text(OBJ)], |bytes, folder| {
            let mut text = bytes;
            let _ = Mesh::from_obj("a", &mut text);
            object("obj", bytes, folder)
        }),
        (
            "object_stl",
            vec![text(STL), binary_stl()],
            |bytes, folder| object("stl", bytes, folder),
        ),
        (
            "object_ply",
            vec![text(PLY), binary_ply()],
            |bytes, folder| object("ply", bytes, folder),
        ),
        (
            "object_gltf",
            vec![gltf().0, text(GLTF)],
            |bytes, folder| object("gltf", bytes, folder),
        ),
        ("object_glb", vec![gltf().1], |bytes, folder| {
            object("glb", bytes, folder)
        }),
        ("object_toml", vec![text(SHAPES)], |bytes, _| {
            told(settings::<Assembly>(bytes)?.object("a"))
        }),
        (
            "object_json",
            vec![bytes("data/objects/bottle_square.json"), text("{}")],
            |bytes, _| told(Description::from_json("a", &String::from_utf8_lossy(bytes))),
        ),
        (
            "safetensors",
            vec![
                bytes("tests/reference/deepsdf/small_model.safetensors"),
                checkpoint(),
            ],
            |bytes, _| told(Tensors::from_bytes("a", bytes)),
        ),
        (
            "specs",
            vec![bytes("tests/reference/deepsdf/small_specs.json")],
            |bytes, _| told(Specs::from_json("a", &String::from_utf8_lossy(bytes))),
        ),
        (
            "npz",
            vec![
                npz(CompressionMethod::Stored),
                npz(CompressionMethod::Deflated),
            ],
            mano,
        ),
        ("parquet", vec![parquet()], grasps),
        ("pickle", pickles(), |bytes, folder| {
            published("npy", bytes, folder)
        }),
        ("torch", tensors(), |bytes, folder| {
            published("pt", bytes, folder)
        }),
        ("isaac_yaml", vec![text(ISAAC)], |bytes, folder| {
            published("yaml", bytes, folder)
        }),
        ("graspgen_json", vec![text(TRANSFORMS)], graspgen),
        ("table_csv", vec![text(TABLE)], |bytes, folder| {
            published("csv", bytes, folder)
        }),
        ("table_json", vec![text(ROWS)], |bytes, folder| {
            published("json", bytes, folder)
        }),
        ("table_parquet", vec![parquet()], |bytes, folder| {
            let path = folder.join("t.parquet");
            fs::write(&path, bytes).unwrap();
            let joints: Vec<String> = (0..22).map(|joint| format!("j{joint}")).collect();
            let mapping = Mapping {
                joints: Some(JointColumns::List("joints".to_owned())),
                ..Mapping::default()
            };
            told(exchange::read(&path, &joints, &mapping))
        }),
        ("mapping", vec![text(MAPPING)], mapping),
        ("metadata", vec![described()], metadata),
        (
            "experiment_toml",
            vec![bytes("data/experiments/closed.toml")],
            |bytes, _| {
                let read: Experiment = settings(bytes)?;
                told(read.energy.validate()).and_then(|()| told(read.synthesis.validate()))
            },
        ),
        ("protocol_toml", vec![text(PROTOCOL)], |bytes, _| {
            told(settings::<Protocol>(bytes)?.validate())
        }),
        (
            "rule_toml",
            vec![bytes("data/taxonomy/rule.toml")],
            |bytes, _| told(Rule::parse(&String::from_utf8_lossy(bytes))),
        ),
        ("labeller", vec![labeller()], taught),
        (
            "manifest",
            vec![landscape("landscape.json")],
            |bytes, folder| landscape_with("landscape.json", bytes, folder),
        ),
        (
            "minima_parquet",
            vec![landscape("minima.parquet")],
            |bytes, folder| landscape_with("minima.parquet", bytes, folder),
        ),
        (
            "edges_parquet",
            vec![landscape("edges.parquet")],
            |bytes, folder| landscape_with("edges.parquet", bytes, folder),
        ),
        (
            "stationary_parquet",
            vec![landscape("stationary.parquet")],
            |bytes, folder| landscape_with("stationary.parquet", bytes, folder),
        ),
        (
            "attempts_parquet",
            vec![landscape("attempts.parquet")],
            |bytes, folder| landscape_with("attempts.parquet", bytes, folder),
        ),
        ("journal", vec![journal()], read_journal),
        ("exchange", vec![text(EXCHANGE)], minima),
        ("sets_of_minima", vec![b"2\n1\n2\n".to_vec()], set_of_minima),
        ("points_text", vec![text(POINTS)], |bytes, _| {
            told(points_of_text(bytes))
        }),
        (
            "points_binary",
            vec![points([[0.5, -1.0, 1e-300].as_slice(); 2])],
            |bytes, _| {
                let read = read_points(bytes, 3);
                read.map(|_| ()).ok_or("no points".to_owned())
            },
        ),
    ]
}

pub(crate) fn told<T, E: std::fmt::Display>(result: Result<T, E>) -> Result<(), String> {
    result.map(|_| ()).map_err(|error| error.to_string())
}

/// The sections that the command line reads.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, default)]
#[derive(Default)]
pub(crate) struct Experiment {
    pub(crate) energy: EnergySettings,
    pub(crate) synthesis: SynthesisSettings,
}

/// Poses a hand that was read.
fn posed(hand: Result<Hand, HandError>) -> Result<(), String> {
    let hand = hand.map_err(|error| error.to_string())?;
    let mut posed = PosedHand::default();
    hand.pose(&hand.rest_coordinates(), &mut posed);
    let finite = posed.points.iter().flatten().all(|x| x.is_finite());
    assert!(finite, "a point is lost");
    Ok(())
}

/// URDF or MJCF with few surface points, because these cost the most time.
fn hand(bytes: &[u8], _: &Path) -> Result<(), String> {
    let text = String::from_utf8_lossy(bytes);
    posed(Hand::from_files(&HandFiles::of_texts([
        ["hand", &text],
        ["hand.json", r#"{"surface_points": 20}"#],
    ])))
}

fn side(bytes: &[u8], _: &Path) -> Result<(), String> {
    let text = String::from_utf8_lossy(bytes);
    posed(Hand::from_files(&HandFiles::of_texts([
        ["hand", URDF],
        ["hand.json", &text],
    ])))
}

fn hand_mesh(kind: &str, bytes: &[u8], folder: &Path) -> Result<(), String> {
    let mesh = format!(r#"<geometry><mesh filename="m.{kind}"/></geometry>"#);
    let urdf = URDF.replace(
        r#"<geometry><cylinder radius="0.01" length="0.05"/></geometry>"#,
        &mesh,
    );
    let path = folder.join("hand.urdf");
    fs::write(folder.join(format!("m.{kind}")), bytes).unwrap();
    fs::write(&path, urdf).unwrap();
    fs::write(folder.join("hand.json"), r#"{"surface_points": 20}"#).unwrap();
    posed(HandFiles::load(&path).and_then(|files| Hand::from_files(&files)))
}

/// Valid files are refused too, because they have only a few of MANO's arrays.
fn mano(bytes: &[u8], folder: &Path) -> Result<(), String> {
    let path = folder.join("m.npz");
    fs::write(&path, bytes).unwrap();
    posed(HandFiles::load(&path).and_then(|files| Hand::from_files(&files)))
}

fn object(kind: &str, bytes: &[u8], folder: &Path) -> Result<(), String> {
    let path = folder.join(format!("m.{kind}"));
    fs::write(&path, bytes).unwrap();
    told(Mesh::load(&path))
}

/// Grasps of another program, for a hand with one joint.
fn published(kind: &str, bytes: &[u8], folder: &Path) -> Result<(), String> {
    let path = folder.join(format!("g.{kind}"));
    fs::write(&path, bytes).unwrap();
    told(exchange::read(&path, &joints(), &Mapping::default()))
}

/// Grasps without joints, of a hand that rests.
fn graspgen(bytes: &[u8], folder: &Path) -> Result<(), String> {
    let path = folder.join("g.json");
    fs::write(&path, bytes).unwrap();
    let hand = exchange::HandJoints {
        rest: Some(vec![0.02]),
        ..joints().as_slice().into()
    };
    told(exchange::read(&path, hand, &Mapping::default()))
}

pub(crate) fn settings<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, String> {
    toml_text::parse(&String::from_utf8_lossy(bytes)).map_err(|error| error.to_string())
}

/// A labeller that is read, names a grasp, and is written as it was read.
fn taught(bytes: &[u8], _: &Path) -> Result<(), String> {
    let read = Taught::parse(&String::from_utf8_lossy(bytes)).map_err(|error| error.to_string())?;
    let again = Taught::parse(&read.text());
    assert!(again.is_ok_and(|again| again == read), "it changes");
    let one = example(0);
    let probabilities = read.probabilities(&one.features, &one.rule);
    let probabilities = probabilities.map_err(|error| error.to_string())?;
    let sum: f64 = probabilities.iter().sum();
    assert!((sum - 1.0).abs() < 1e-9, "{sum}");
    Ok(())
}

fn mapping(bytes: &[u8], folder: &Path) -> Result<(), String> {
    let mapping = settings(bytes)?;
    let path = folder.join("g.csv");
    fs::write(&path, TABLE).unwrap();
    told(exchange::read(&path, &joints(), &mapping))
}

fn grasps(bytes: &[u8], folder: &Path) -> Result<(), String> {
    let path = folder.join("g.parquet");
    fs::write(&path, bytes).unwrap();
    told(GraspFile::read(&path, Overrides::default()))
}

/// The same grasps with these metadata.
fn metadata(bytes: &[u8], folder: &Path) -> Result<(), String> {
    static GRASPS: OnceLock<Bytes> = OnceLock::new();
    let own = GRASPS.get_or_init(|| Bytes::from(parquet())).clone();
    let reader = ParquetRecordBatchReader::try_new(own, 1024).unwrap();
    let batch = reader.into_iter().next().unwrap().unwrap();
    let text = String::from_utf8_lossy(bytes).into_owned();
    let pairs = vec![KeyValue::new(OWN_KEY.to_owned(), text)];
    let properties = WriterProperties::builder().set_key_value_metadata(Some(pairs));
    let path = folder.join("g.parquet");
    let file = File::create(&path).unwrap();
    let mut writer = ArrowWriter::try_new(file, batch.schema(), Some(properties.build())).unwrap();
    writer.write(&batch).unwrap();
    writer.close().unwrap();
    told(GraspFile::read(&path, Overrides::default()))
}

/// A landscape with one replaced file.
fn landscape_with(name: &str, bytes: &[u8], folder: &Path) -> Result<(), String> {
    for file in fs::read_dir(landscape_folder()).unwrap() {
        let file = file.unwrap();
        let to = folder.join(file.file_name());
        if file.file_name() != name && !to.exists() {
            fs::copy(file.path(), to).unwrap();
        }
    }
    fs::write(folder.join(name), bytes).unwrap();
    list_checksums(folder);
    let files = LandscapeFiles::read(folder).map_err(|error| error.to_string())?;
    told(StationaryRow::read(folder))?;
    told(read_attempts(folder, &files))
}

/// Lets the manifest in `folder`, if it is one, list the checksums of the tables as they are. Otherwise no reader would go
/// beyond them.
fn list_checksums(folder: &Path) {
    let path = folder.join("landscape.json");
    let Ok(mut manifest) = serde_json::from_slice::<serde_json::Value>(&fs::read(&path).unwrap())
    else {
        return;
    };
    let Some(entries) = manifest.as_object_mut() else {
        return;
    };
    entries.remove("checksums");
    let mut checksums = serde_json::Map::new();
    for file in fs::read_dir(folder).unwrap() {
        let file = file.unwrap().path();
        let name = file.file_name().unwrap().to_str().unwrap();
        if name.ends_with(".parquet") {
            let bytes = fs::read(&file).unwrap();
            checksums.insert(name.to_owned(), content_hash(&[&bytes]).into());
        }
    }
    let own = content_hash(&[format!("{manifest:#}\n").as_bytes()]);
    checksums.insert("landscape.json".to_owned(), own.into());
    manifest["checksums"] = checksums.into();
    fs::write(path, format!("{manifest:#}\n")).unwrap();
}

/// Complete records are read, the rest is cut off, and the journal can be continued.
fn read_journal(bytes: &[u8], folder: &Path) -> Result<(), String> {
    let path = folder.join("journal");
    fs::write(&path, bytes).unwrap();
    let open = || Journal::open(&path, INPUT_HASH, false).map_err(|error| error.to_string());
    let journal = open()?;
    journal.put("one more", b"[2]").unwrap();
    let count = journal.len();
    drop(journal);
    let journal = open()?;
    let kept = (
        journal.len(),
        journal.dropped_bytes(),
        journal.get("one more"),
    );
    assert_eq!(
        kept,
        (count, 0, Some(b"[2]".to_vec())),
        "the journal went on"
    );
    Ok(())
}

/// A set of minima of a landscape.
fn set_of_minima(bytes: &[u8], folder: &Path) -> Result<(), String> {
    fs::write(folder.join("min.data"), "0 2 1 0 0 0\n1 2 1 0 0 0\n").unwrap();
    fs::write(folder.join("ts.data"), "").unwrap();
    let states = NetworkOfStates::open(folder, &FamilySettings::default()).unwrap();
    told(states.minima_of(&String::from_utf8_lossy(bytes)))
}

/// The two files are one text, split at its middle. The tree is built as well.
fn minima(bytes: &[u8], _: &Path) -> Result<(), String> {
    let text = String::from_utf8_lossy(bytes);
    let lines: Vec<&str> = text.lines().collect();
    let (minima, states) = lines.split_at(lines.len() / 2);
    let read = Database::parse(&minima.join("\n"), &states.join("\n"));
    let (database, _) = read.map_err(|error| error.to_string())?;
    let _ = Tree::from_network(&database.network(), Evidence::Chain);
    Ok(())
}
