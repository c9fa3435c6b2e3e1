//! The command recorded in a file makes the file again byte for byte: for every verb, with every flag, for any input names.
#![cfg(unix)]

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;
use std::process::Command;
use std::sync::OnceLock;

use landscape::cli::definition;
use landscape::hand::HandFiles;
use landscape::store::{GraspFile, LandscapeFiles, Overrides};

use crate::desk::Desk;
use crate::diversity::plant;
use crate::table::rows;
use crate::{contents, grasps, held_grasps};

/// Runs of every verb that records its command. Together they use all its flags. `@` stands for the folder of the inputs.
const RUNS: &str = r#"
    synth | --hand | @/robot/urdf/own's hand.urdf | --hand-folder | @/robot | --mirror | --object | @/Kugel ü.obj | --scale | 1.1 | --name | Kanne 'x' | -n | 3 | --steps | 1 | --seed | 7 | --config | @/-set.toml | --keep | all | --spread | 2
    synth | --object | ball | -n | 2 | --steps | 1 | --keep | all
    synth | --object | @/half shell.obj | --scale | 0.8 | --thickness | 2.5 | -n | 2 | --steps | 1 | --keep | all
    synth | --from | @/-g.parquet | --perturb | 3 | --steps | 1 | --keep | all | --hand | @/own's hand.urdf
    synth | --object | @/one/shapes.toml | --config | @/two/shapes.toml | -n | 2 | --steps | 1 | --keep | all
    synth | --object | pen | -n | 8 | --steps | 6 | --keep | all | --types | 9,Prismatic 2 Finger | --cells | precision/pad/2-3/abducted | --grips | thumb+index,thumb+index+middle | --regions | thumb.distal.pad,index.distal | --regions | thumb,middle.distal
    synth | --from | @/-g.parquet | --beyond | @/-g.parquet | -n | 3 | --apart | 4 | --chance | 0.3 | --steps | 1 | --keep | all
    synth | --beyond | @/it's old | -n | 4 | --steps | 1 | --keep | all | --apart | 0.01
    build | @/held $1.parquet | --neighbours | 1 | --temperature | 0.02 | --pull | 40 | --family-barrier | 0.05 | --only-stable | --first | 3 | --seed | 5 | --object | ball | --config | @/map it's.toml
    build | @/-g.parquet | --onto | @/it's old
    build | @/-g.parquet | --onto | @/it's old | --connect | m0 | 1
    build | @/-g.parquet | --first | 2 | --search | adelm | --config | @/map it's.toml | --hand | @/own's hand.urdf | --object | @/Kugel ü.obj
    surface | muller-brown | --region=-1.6:1.2,-0.3:2 | --patience | 2 | --searches | 40 | --seed | 3 | --family-barrier | 0.5 | --config | @/search.toml
    surface | --command | python3 "waves it's.py" | --region | 0:6x2 | --coordinates | angles | --symmetries | @/own's copies.txt | --answer-seconds | 90 | --protocol | json | --searches | 20
    surface | --command | python3 pairs.py | --region=-1:1x9 | --coordinates | atoms | --elements | Ar2,Kr | --searches | 20
    surface | muller-brown | --search | lowest | --lowest | 3 | --searches | 64 | --budget | 2h | --from | @/known points.txt
    surface | muller-brown | --searches | 64 | --connect | m0 | m2
    import | @/t.csv | --hand | @/robot/urdf/own's hand.urdf | --hand-folder | @/robot | --mirror | --object | @/Kugel ü.obj | --scale | 1.25 | --name | my mug's | --mapping | @/m.toml
    import | @/my arrays | --hand | human | --object | ball
    import | @/t.csv | --hand | human | --object | @/half shell.obj | --scale | 1 | --thickness | 3
    import | @/my data | --family-barrier | 0.1
    label | @/-g.parquet | --from | @/l.csv | --rule | @/rule.toml | --by | @/-my.labeller | --hand | @/own's hand.urdf | --object | @/Kugel ü.obj
    join | @/-g.parquet | @/held $1.parquet | --hand | @/own's hand.urdf | --object | @/Kugel ü.obj
    stability | @/-g.parquet | --config | @/short.toml | --hand | @/own's hand.urdf | --object | @/Kugel ü.obj
    stability | @/one.parquet | --protocol | dexgraspbench
    survey | @/held $1.parquet | --only-stable | --first | 3 | --family-barrier | 0.05 | --config | @/map it's.toml | --seed | 5 | --object | ball
    survey | @/-g.parquet | --no-map | --hand | @/own's hand.urdf
"#;

/// Flags that do not change the output of these verbs, with the reason.
const WITHOUT_TRACE: &str = "
    drop | tells how a sample fares; the file is written before
    threads | any number of threads gives the same bytes
    quiet | tells less
    json | tells the same in another form
    verbose | tells more
    log-format | tells the same in another form
    force | changes nothing but whether there was something before
    answer-seconds | ends a run, or changes nothing of what it finds
    resume | continues an interrupted run, which ends in the same bytes
    task | maps a part, which ends in the same bytes
    fresh | does what would have been done before
    output | is the name of what is written
    help | writes nothing
    version | writes nothing
    explain | writes nothing
    learn | writes a labeller, which has the hashes of the files that taught it
    no-report | leaves out a page and changes no other file
";

/// A folder of input files with unusual names.
fn inputs() -> &'static Desk {
    static INPUTS: OnceLock<Desk> = OnceLock::new();
    INPUTS.get_or_init(|| {
        let desk = Desk::empty();
        let write = |name: &str, text: &str| desk.write(name, text);
        for folder in ["robot", "robot/urdf", "one", "two", "my arrays"] {
            fs::create_dir(desk.path(folder)).unwrap();
        }
        let human = HandFiles::named("human").unwrap().files;
        let [urdf, side] = [&human[0].text, &human[1].text];
        for folder in ["", "robot/urdf/"] {
            write(&format!("{folder}own's hand.urdf"), urdf);
            write(&format!("{folder}own's hand.json"), side);
        }
        let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("data");
        let copy = |from: &str, to: &str| fs::copy(data.join(from), desk.path(to)).unwrap();
        copy("objects/ball.obj", "Kugel ü.obj");
        // Heavier than the ball, so that it is another object.
        let ball = fs::read_to_string(data.join("objects/ball.json")).unwrap();
        let mut ball: serde_json::Value = serde_json::from_str(&ball).unwrap();
        ball["mass_kg"] = 0.5.into();
        write("Kugel ü.json", &ball.to_string());
        let whole = fs::read_to_string(data.join("objects/ball.obj")).unwrap();
        let faces = whole.lines().filter(|line| line.starts_with('f')).count();
        let (mut kept, mut seen) = (String::new(), 0);
        for line in whole.lines() {
            seen += usize::from(line.starts_with('f'));
            if 2 * seen <= faces {
                kept += line;
                kept.push('\n');
            }
        }
        write("half shell.obj", &kept);
        copy("taxonomy/rule.toml", "rule.toml");
        write(
            "-set.toml",
            "[energy]\nprior_weight = 0.02\n[synthesis]\nsteps = 2\n",
        );
        write(
            "one/shapes.toml",
            "[[parts]]\nsphere = { centre = [0, 0, 0], radius_m = 0.03 }\n",
        );
        write(
            "known points.txt",
            "0.6 0.03\n-0.5, 1.4  # near a minimum\n",
        );
        write("two/shapes.toml", "[energy]\nprior_weight = 0.03\n");
        write(
            "map it's.toml",
            "[map]\nsearches = 2\n[map.chain]\npatience = 120\n",
        );
        write("search.toml", "[search]\nmodes = 3\n");
        write(
            "short.toml",
            "protocol = \"drop\"\nsteps = 60\nsettle_s = 0.2\n",
        );
        write("l.csv", "id,label\n2,Tripod\n");
        write("m.toml", "scale = 1.25\n");
        write("waves it's.py", WAVES);
        write(
            "own's copies.txt",
            "1 2 # every point is its own only copy\n",
        );
        write("pairs.py", PAIRS);
        desk.write("-g.parquet", grasps());
        desk.write("held $1.parquet", held_grasps());
        desk.write("held.parquet", grasps());
        let mut one = desk.grasps("-g.parquet");
        one.grasps.truncate(1);
        one.write(&desk.path("one.parquet")).unwrap();
        desk.succeed("export held.parquet csv -q -o t.csv");
        desk.succeed("export held.parquet dexgraspnet -q -o a.npy");
        fs::rename(desk.path("a.npy"), desk.path("my arrays/a.npy")).unwrap();
        let types = ["Medium Wrap", "Tripod"];
        plant(&desk, "named.parquet", 30, &types, false);
        desk.succeed("label --learn named.parquet -q -o ./-my.labeller");
        fs::remove_file(desk.path("named.parquet")).unwrap();
        desk.add_landscape("it's old");
        desk.add_database("my data");
        desk
    })
}

/// An energy of two angles.
const WAVES: &str = r#"
import json, math, sys
for line in sys.stdin:
    a, b = json.loads(line)["x"]
    energy = math.cos(a) + math.cos(2 * b) + 0.2 * math.sin(a + b)
    slope = 0.2 * math.cos(a + b)
    print(json.dumps({"energy": energy, "gradient": [slope - math.sin(a), slope - 2 * math.sin(2 * b)]}), flush=True)
"#;

/// Two atoms of argon and one of krypton.
const PAIRS: &str = r#"
import json, sys
for line in sys.stdin:
    x = json.loads(line)["x"]
    energy, gradient = 0.0, [0.0] * 9
    for i, j in [(0, 1), (0, 2), (1, 2)]:
        size = 1.0 if j == 1 else 1.05
        arm = [x[3 * i + k] - x[3 * j + k] for k in range(3)]
        square = sum(a * a for a in arm)
        power = (size * size / square) ** 3
        energy += 4 * power * (power - 1)
        slope = -24 * power * (2 * power - 1) / square
        for k in range(3):
            gradient[3 * i + k] += slope * arm[k]
            gradient[3 * j + k] -= slope * arm[k]
    print(json.dumps({"energy": energy, "gradient": gradient}), flush=True)
"#;

/// The output of a run, without its durations.
fn written(path: &Path) -> BTreeMap<String, Vec<u8>> {
    if path.is_file() {
        return BTreeMap::from([(String::new(), fs::read(path).unwrap())]);
    }
    let files = contents(path).into_iter();
    files
        .map(|(name, bytes)| {
            (
                name.strip_prefix(path).unwrap().display().to_string(),
                bytes,
            )
        })
        .filter(|(name, _)| !name.ends_with("timings.json"))
        .collect()
}

fn recorded(path: &Path) -> String {
    if let Ok(survey) = fs::read(path.join("survey.json")) {
        let survey: serde_json::Value = serde_json::from_slice(&survey).unwrap();
        return survey["command"].as_str().unwrap().to_owned();
    }
    if path.is_dir() {
        return LandscapeFiles::read(path).unwrap().manifest.command;
    }
    let (file, _) = GraspFile::read(path, Overrides::default()).unwrap();
    file.metadata.command
}

/// Runs all commands of one verb from one folder with absolute paths. Then a shell in another folder runs the recorded
/// commands.
fn remade(verb: &str) {
    let program = Path::new(env!("CARGO_BIN_EXE_landscape"));
    let path = std::env::join_paths(std::iter::once(program.parent().unwrap().to_owned()).chain(
        std::env::split_paths(&std::env::var_os("PATH").unwrap_or_default()),
    ))
    .unwrap();
    let python = Command::new("python3").arg("--version").output().is_ok();
    for run in rows(RUNS).filter(|run| run[0] == verb) {
        let arguments = &run[1..];
        if arguments.iter().any(|word| word.contains("python3")) && !python {
            crate::skipped::skipped("there is no python3");
            continue;
        }
        let first = Desk::empty();
        first.write("waves it's.py", WAVES);
        first.write("pairs.py", PAIRS);
        let folder = inputs().folder.path().display().to_string();
        let given = arguments.iter().map(|word| word.replacen('@', &folder, 1));
        let output = first
            .command(&format!("{verb} --threads 1 -q -o out.parquet"))
            .args(given)
            .output()
            .unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{verb} {arguments:?}: {said}");

        let command = recorded(&first.path("out.parquet"));
        assert!(
            !command.contains(&folder) && !command.contains("/tmp"),
            "{command}"
        );
        let again = inputs().copied();
        let before: BTreeSet<String> = crate::names(again.folder.path()).into_iter().collect();
        let output = Command::new("sh")
            .arg("-c")
            .arg(format!("{command} --quiet"))
            .env("PATH", &path)
            .current_dir(again.folder.path())
            .output()
            .unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{command}: {said}");
        let after: BTreeSet<String> = crate::names(again.folder.path()).into_iter().collect();
        let new: Vec<&String> = after.difference(&before).collect();
        let [name] = new.as_slice() else {
            panic!("{command} wrote {new:?}");
        };
        let [once, twice] =
            [first.path("out.parquet"), again.path(name)].map(|path| written(&path));
        let differ: Vec<&String> = once
            .keys()
            .chain(twice.keys())
            .filter(|file| once.get(*file) != twice.get(*file))
            .collect();
        assert!(differ.is_empty(), "{command}: {differ:?} of {name} differ");
    }
}

#[test]
fn recorded_grasps_are_remade() {
    for verb in ["synth", "import", "join", "label", "stability"] {
        remade(verb);
    }
}

#[test]
fn recorded_landscapes_are_remade() {
    for verb in ["build", "surface", "survey"] {
        remade(verb);
    }
}

/// A new flag must be in [`RUNS`] or in the list of flags that leave no trace, with the reason.
#[test]
fn every_flag_is_recorded_or_leaves_no_trace() {
    let definition = definition();
    let verbs: BTreeSet<&str> = rows(RUNS).map(|run| run[0]).collect();
    for verb in verbs {
        let given: BTreeSet<String> = rows(RUNS)
            .filter(|run| run[0] == verb)
            .flatten()
            .filter_map(|word| word.split('=').next()?.strip_prefix('-'))
            .map(|word| word.trim_start_matches('-').to_owned())
            .collect();
        let command = definition.find_subcommand(verb).unwrap();
        for flag in command.get_arguments().filter(|arg| !arg.is_positional()) {
            let long = flag.get_long().unwrap_or_default();
            let short = flag.get_short().map(String::from).unwrap_or_default();
            assert!(
                given.contains(long)
                    || given.contains(&short)
                    || rows(WITHOUT_TRACE).any(|row| row[0] == long),
                "`landscape {verb} --{long}` is not among the runs whose recorded commands are tried"
            );
        }
    }
}

/// A file to which labels and outcomes of simulations were added still records how its grasps were made, and from which
/// files.
#[test]
fn earlier_commands_are_kept() {
    let desk = Desk::with_grasps();
    desk.succeed("label g.parquet -q -o l.parquet");
    let file = desk.grasps("l.parquet");
    let metadata = file.metadata;
    assert_eq!(metadata.command, "landscape label g.parquet");
    let [input] = metadata.inputs.as_slice() else {
        panic!("{:?}", metadata.inputs);
    };
    assert_eq!(input.name, "g.parquet");
    assert_eq!(
        input.content_hash,
        landscape::store::content_hash(&[grasps()])
    );
    let [before] = metadata.earlier.as_slice() else {
        panic!("{:?}", metadata.earlier);
    };
    let file = desk.grasps("g.parquet");
    assert_eq!(before.command, file.metadata.command);
    assert_eq!(
        before.command,
        "landscape synth --object ball -n 6 --steps 1 --seed 1 --keep all"
    );
}
