//! Output files: files of the user are never overwritten, write errors are reported, and no incomplete set of files stays.

use std::fs;
#[cfg(unix)]
use std::io::{BufRead, BufReader, Read};
#[cfg(unix)]
use std::process::{Command, Stdio};

use crate::desk::{Desk, assert_says};
use crate::diversity::plant;
use crate::table::rows;
use crate::{LONG_SYNTH, contents, grasps, names, records};

const TETRAHEDRON: &str =
    "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
const WORK: &[u8] = b"years of work";

/// A folder with a landscape and its grasps.
fn desk() -> Desk {
    let desk = Desk::with_grasps();
    desk.add_landscape("g.landscape");
    desk.write("box.obj", TETRAHEDRON);
    plant(&desk, "named.parquet", 30, &["Ring", "Tripod"], false);
    desk
}

/// Every verb that writes files, and the files.
const WRITES: &str = "
    synth --object ball -n 1 --steps 1 --keep all --drop 0 | grasps.parquet
    synth --object ball -n 1 --steps 1 --keep all -o box.obj --drop 0 | box.obj
    stability g.parquet | g.stability.parquet
    label g.parquet | g.labelled.parquet
    label --learn named.parquet | named.labeller
    report g.parquet | g.grasps.html
    report g.landscape | g.report.html
    export g.parquet csv | g.csv
    export g.parquet json | g.json
    export g.parquet qpos -o q.npy | q.npy
    export g.parquet qpos | g.qpos.csv
    export g.parquet isaac_grasp | g.isaac_grasp.yaml
    export g.parquet graspgen | g.graspgen.json
    export g.landscape roadmap | g.roadmap.json
    export g.parquet dexonomy --grasp 0 -o one.npy | one.npy
    export g.parquet glb --grasp 0 -o one.glb | one.glb
    export g.parquet usd --grasp 0 -o one.usda | one.usda
    hands inspect gripper_three_finger | gripper_three_finger.png
    hands can human pen -n 1 | human.can.csv | human.can.md | human.can.json | human.can.png | human.can.svg
    objects inspect box.obj | box.png
    objects inspect box.obj --side-file s.json | box.png
    objects inspect box.obj -o other | other.png
    compare g.landscape | g.comparison.md | g.comparison.json | g.comparison.png | g.comparison.svg
    judge g.parquet --tests drop --measures none | g.judge.grasps.csv | g.judge.csv | g.judge.md | g.judge.json | g.judge.png | g.judge.svg
    inspect g.landscape --path m0 m1 | g.m0-m1.glb | g.m0-m1.svg | g.m0-m1.png
";

#[test]
fn nothing_is_overwritten_that_was_not_made_here() {
    for row in rows(WRITES) {
        let (line, outputs) = (row[0], &row[1..]);
        let desk = desk();
        for output in outputs {
            desk.write(output, WORK);
            assert_says(&desk.early_mistake(line), &[output, "--force"]);
        }
        // A simulation takes long, and is written as labels are.
        if line.starts_with("stability") {
            continue;
        }
        desk.succeed(&format!("{line} --force"));
        let made = |output: &&str| desk.bytes(output);
        let first: Vec<_> = outputs.iter().map(made).collect();
        assert!(first.iter().all(|bytes| bytes != WORK), "{line}");
        // What it made itself, it makes again; a mesh of the user it does not.
        if !outputs.contains(&"box.obj") {
            let force = line.starts_with("hands") || line.contains("side-file");
            desk.succeed(&format!("{line}{}", if force { " --force" } else { "" }));
            let again: Vec<_> = outputs.iter().map(made).collect();
            assert!(first == again, "{line} again");
        }
    }
}

#[test]
fn an_output_is_no_input() {
    let desk = desk();
    desk.write("labels.csv", "id,label\n");
    let again = desk.bytes("g.parquet");
    for line in [
        "label g.parquet -o g.parquet",
        "label g.parquet -o ./g.parquet",
        "report g.parquet -o g.parquet",
        "report g.landscape -o g.landscape",
        "label g.parquet --from labels.csv -o labels.csv",
        "label --learn named.parquet -o named.parquet",
        "label g.parquet --by labels.csv -o labels.csv",
        "stability g.parquet -o g.parquet",
        "synth --from g.parquet -n 1 -o g.parquet",
        "export g.parquet glb -o g.landscape/..",
        "draw g.landscape -o g.landscape",
        "build g.parquet -o g.parquet",
        "import g.parquet --hand human --object ball -o g.parquet",
    ] {
        let sentence = desk.early_mistake(line);
        let said = [
            "is an input of this command",
            "exists and was not made",
            "folder contains",
            "this is a folder",
        ];
        assert!(
            said.iter().any(|words| sentence.contains(words)),
            "{line}: {sentence}"
        );
    }
    assert_eq!(again, grasps());
    desk.succeed("label g.parquet -o g.parquet --force");
    assert_ne!(desk.bytes("g.parquet"), again, "labels in place");
}

/// Folders into which several files are written keep their other files.
#[test]
fn folders_of_others_are_not_written_into() {
    let desk = desk();
    for (line, own) in [
        ("draw g.landscape -o out", "disconnectivity.png"),
        ("export g.parquet glb -o out", "0.glb"),
        ("export g.parquet mujoco -o out", "scene.xml"),
        ("export g.parquet urdf -o out", "human.urdf"),
    ] {
        fs::create_dir(desk.path("out")).unwrap();
        desk.write("out/thesis.tex", WORK);
        let sentence = desk.early_mistake(line);
        assert_says(&sentence, &["--output out", "thesis.tex", "--force"]);
        desk.succeed(&format!("{line} --force"));
        assert_eq!(desk.bytes("out/thesis.tex"), WORK);
        fs::remove_file(desk.path("out/thesis.tex")).unwrap();
        let first = contents(&desk.path("out"));
        assert!(desk.path("out").join(own).is_file());
        desk.succeed(line);
        assert!(contents(&desk.path("out")) == first, "{line} again");
        fs::remove_dir_all(desk.path("out")).unwrap();
    }
}

#[cfg(target_os = "linux")]
#[test]
fn standard_output_that_cannot_be_written_is_an_error() {
    let desk = desk();
    for line in [
        "hands list",
        "--help",
        "diff g.landscape g.landscape",
        "label g.parquet",
    ] {
        let full = fs::OpenOptions::new()
            .write(true)
            .open("/dev/full")
            .unwrap();
        let output = desk
            .command(line)
            .stdout(full)
            .stderr(Stdio::piped())
            .output()
            .unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(1), "{line}: {said}");
        assert_says(&said, &["error: cannot write to standard output"]);

        // Whoever closes the pipe has read enough.
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        let output = desk
            .command(line)
            .stdout(writer)
            .stderr(Stdio::piped())
            .output()
            .unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(141), "{line}: {said}");
        assert!(!said.contains("error"), "{line}: {said}");
    }
    assert!(
        desk.path("g.labelled.parquet").exists(),
        "the work is done all the same"
    );
}

/// Whether this process, and so its children, ignores SIGINT, as processes do that a shell started in the background.
#[cfg(unix)]
fn interrupts_are_ignored() -> bool {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    mask.is_some_and(|mask| u64::from_str_radix(mask.trim(), 16).unwrap() & 2 != 0)
}

#[cfg(unix)]
#[test]
fn an_interrupted_run_says_what_is_kept() {
    for (signal, code) in [("INT", 130), ("TERM", 75)] {
        if signal == "INT" && interrupts_are_ignored() {
            crate::skipped::skipped("SIGINT is ignored here, as in the background of a shell");
            continue;
        }
        let desk = Desk::empty();
        let line = LONG_SYNTH.replace(" -q", "");
        let child = desk
            .command(&line.replace("-n 12", "-n 2000"))
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        while records(&desk.path("grasps.parquet.partial")).is_empty() {
            std::thread::sleep(std::time::Duration::from_millis(1));
        }
        let sent = Command::new("kill")
            .args(["-s", signal, &child.id().to_string()])
            .status()
            .unwrap();
        assert!(sent.success());
        let output = child.wait_with_output().unwrap();
        assert_eq!(output.status.code(), Some(code));
        let said = String::from_utf8(output.stderr).unwrap();
        assert_says(
            &said,
            &[
                "interrupted: finished tasks are kept in grasps.parquet.partial",
                "the same command",
            ],
        );
        assert_eq!(names(desk.folder.path()), ["grasps.parquet.partial"]);
        let said = desk.succeed(&line.replace("-n 12", "-n 1"));
        assert_says(&said, &["continuing an interrupted run"]);
    }
}

/// A scheduler that sends SIGTERM need not run a command again that has no finished tasks to go on from.
#[cfg(unix)]
#[test]
fn a_command_without_finished_tasks_ends_as_other_programs() {
    let desk = Desk::empty();
    let data = concat!(env!("CARGO_MANIFEST_DIR"), "/data/grasps.parquet");
    let mut child = desk
        .command("label -v --threads 1 -o out.parquet")
        .arg(data)
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // Once it tells what it does, it handles signals.
    let mut told = BufReader::new(child.stderr.take().unwrap());
    let mut first = String::new();
    told.read_line(&mut first).unwrap();
    assert_says(&first, &["landscape", "1 threads", "landscape label"]);
    let sent = Command::new("kill")
        .args(["-s", "TERM", &child.id().to_string()])
        .status()
        .unwrap();
    assert!(sent.success());
    let mut rest = String::new();
    told.read_to_string(&mut rest).unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(143));
    assert_says(&rest, &["interrupted: nothing was written"]);
    assert_eq!(names(desk.folder.path()), [""; 0]);
}

/// The program goes on ignoring the signals that `nohup` or a shell made it ignore.
#[cfg(target_os = "linux")]
#[test]
fn signals_that_are_to_be_ignored_are_ignored() {
    let desk = Desk::empty();
    let program = env!("CARGO_BIN_EXE_landscape");
    let line = format!("trap '' INT; exec {program} {LONG_SYNTH}");
    let mut child = Command::new("bash")
        .args(["-c", &line])
        .current_dir(desk.folder.path())
        .spawn()
        .unwrap();
    while records(&desk.path("grasps.parquet.partial")).is_empty() {
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    let sent = Command::new("kill")
        .args(["-s", "INT", &child.id().to_string()])
        .status()
        .unwrap();
    assert!(sent.success());
    assert!(child.wait().unwrap().success());
    assert_eq!(names(desk.folder.path()), ["grasps.parquet"]);
}

/// What a run has made and could not fill is not left behind. Files of this process cannot grow, as on a full disk.
#[cfg(unix)]
#[test]
fn a_full_disk_leaves_no_empty_folder() {
    let desk = Desk::with_grasps();
    let before = contents(desk.folder.path());
    for line in [
        "export g.parquet glb -o b.scenes",
        "build g.parquet --first 2",
    ] {
        let shell = format!(
            "trap '' XFSZ; ulimit -f 0; exec {} {line}",
            env!("CARGO_BIN_EXE_landscape")
        );
        let output = Command::new("sh")
            .args(["-c", &shell])
            .current_dir(desk.folder.path())
            .output()
            .unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(1), "{said}");
        assert!(said.contains("cannot write"), "{said}");
        assert_eq!(contents(desk.folder.path()), before, "{line}");
    }
}

/// Files of the same name in other folders are other hands and objects: their pictures are not overwritten unasked.
#[test]
fn pictures_of_other_files_of_the_same_name_stay() {
    let desk = Desk::empty();
    let claw = include_str!("../../python/tutorials/claw/claw.urdf");
    for folder in ["a", "b"] {
        fs::create_dir(desk.path(folder)).unwrap();
        fs::write(desk.path(folder).join("right.urdf"), claw).unwrap();
        fs::write(desk.path(folder).join("right.obj"), TETRAHEDRON).unwrap();
    }
    for verb in ["hands inspect a/right.urdf", "objects inspect a/right.obj"] {
        desk.succeed(&format!("{verb} --quiet"));
        let first = desk.bytes("right.png");
        let other = verb.replace("a/", "b/");
        let sentence = desk.mistake(&format!("{other} --quiet"));
        assert_says(
            &sentence,
            &[
                "right.png shows something else than b/right",
                "-o",
                "--force",
            ],
        );
        assert!(desk.bytes("right.png") == first, "{verb}");
        // The same file by another path, and other pictures.
        desk.succeed(&format!("{} --quiet", verb.replace("a/", "b/../a/")));
        desk.succeed(&format!("{other} --quiet -o other"));
        desk.succeed(&format!("{other} --quiet --force"));
        fs::remove_file(desk.path("right.png")).unwrap();
        fs::remove_file(desk.path("other.png")).unwrap();
    }
}
