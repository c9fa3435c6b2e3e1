//! Help texts, and the error message of every mistake on the command line.

use std::fs;

use crate::desk::{Desk, assert_says};
use crate::names;
use crate::table::rows;

#[test]
fn unwritable_output() {
    let desk = Desk::with_grasps();
    desk.write("taken", "years of work");
    fs::create_dir(desk.path("folder")).unwrap();
    desk.write("folder/thesis.tex", "years of work");
    for command in [
        "build g.parquet",
        "synth --object ball -n 1 --steps 1 --keep all",
    ] {
        for (output, folder) in [("absent/x", "absent"), ("taken/x", "taken")] {
            let sentence = desk.early_mistake(&format!("{command} -o {output}"));
            assert_eq!(
                sentence,
                format!("--output {output}: the folder {folder} does not exist")
            );
        }
    }
    for output in ["taken", "folder"] {
        let sentence = desk.early_mistake(&format!("build g.parquet -o {output}"));
        assert_says(
            &sentence,
            &[&format!("{output} exists and was not made by landscape")],
        );
    }
    for output in ["folder", "."] {
        let sentence = desk.early_mistake(&format!("synth --object ball -n 1 -o {output}"));
        assert_says(&sentence, &[&format!("--output {output}"), "folder"]);
    }
}

#[test]
fn mistakes_in_flags() {
    let desk = Desk::with_grasps();
    desk.write("typo.toml", "[energy]\nprior_wieght = 1.0\n");
    desk.write("negative.toml", "[energy]\nprior_weight = -1.0\n");
    desk.write("large.toml", "[energy]\nprior_weight = 1e155\n");
    desk.write("torn.toml", "[energy");
    desk.write("claw.urdf", "<robot");
    desk.write("empty.obj", "# nothing\n");
    desk.write(
        "open.obj",
        "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\nf 1 3 2\nf 1 2 4\nf 1 4 3\n",
    );
    let cases = "
        synth --object teapot | --object teapot | neither a file nor an object | ball | jar
        synth --object ball --hand claw | --hand claw | neither a file nor a hand | human
        synth --object ball --hand claw.urdf | claw.urdf, line | not XML
        synth --object open.obj | open.obj is not closed: 3 edges border a hole
        synth --object empty.obj | empty.obj has no faces
        synth --object ball -n 0 | -n 0
        synth --object ball --spread 0 | --spread 0
        synth --object ball --config typo.toml | typo.toml | line 2 | prior_wieght | `prior_weight`
        synth --object ball --config negative.toml | negative.toml | [energy] | prior_weight = -1
        synth --object ball --config large.toml | large.toml | prior_weight = 1e155 is not from 0 to 1000000
        synth --object ball --config torn.toml | torn.toml | line 1
        synth --object ball --config absent.toml | cannot read absent.toml
        synth --object ball --threads 0 | --threads 0
        label g.parquet --by absent.labeller | --by: cannot read absent.labeller
        label g.parquet --by typo.toml | typo.toml: | not a labeller that `landscape label --learn` wrote
        label g.parquet g.parquet | several files of grasps | --learn
        label --learn g.parquet | 0 grasps of human-like hands | at least 30
    ";
    for case in rows(cases) {
        let sentence = desk.early_mistake(case[0]);
        assert_says(&sentence, &case[1..]);
        let (_, cause) = sentence.rsplit_once(": ").unwrap_or(("", &sentence));
        assert_eq!(sentence.matches(cause).count(), 1, "said twice: {sentence}");
    }
}

/// Values that would fill the memory, overflow or make a run endless are refused before any work.
#[test]
fn absurd_numbers_are_refused() {
    let desk = Desk::with_grasps();
    let cases = "
        synth --object ball -n 18446744073709551615 | -n 1.8446744073709552e19
        synth --object ball -n 1000001 | -n 1000001
        synth --object ball --steps 4294967295 | --steps
        synth --object ball --threads 18446744073709551615 | --threads
        synth --object ball --scale 1e155 | --scale 1e155
        synth --object ball --scale 1e-300 | --scale 1e-300
        synth --from g.parquet --perturb 1e9 | --perturb 1e9
        synth --object ball --types 34 | --types 34 | 33 grasp types
        synth --object ball --types `Tip Punch` | --types Tip Punch | 33 grasp types
        synth --object ball --cells power | --cells power | 17 cells | precision/pad/2/abducted
        synth --object ball --grips thumb+pinky | pinky | no such digit | thumb, index, middle, ring, little
        synth --object ball --grips thumb | thumb | at least two parts
        synth --object ball --regions thumb.pad,index.distal.pad | thumb.pad | no such region | thumb.distal.pad
        synth --object ball --hand gripper_parallel --types 9 | Palmar Pinch | gripper_parallel | --grips
        synth --object pen --beyond g.parquet | --beyond g.parquet | human hand on pen
        synth --object ball --beyond absent.parquet | absent.parquet
        synth --beyond g.parquet --apart -1 | --apart -1
        synth --beyond g.parquet --chance 2 | --chance 2
        hands can gripper_parallel ball | gripper_parallel | not built like a human one
        hands can human ball ball | ball | two objects
        objects inspect ball --scale 1e300 | --scale 1e300
        build g.parquet --pull 1e300 | --pull 1e300
        build g.parquet --pull 0 | --pull 0 is not
        build g.parquet --temperature -1 | --temperature -1
        build g.parquet --temperature nan | --temperature NaN
        surface muller-brown --searches 18446744073709551615 | --searches
        surface muller-brown --patience 18446744073709551615 | --patience
        surface muller-brown --region=-1e155:1e155x2 | --region -1e155:1e155x2
        surface muller-brown --region=0:1e-300x2 | --region 0:1e-300x2
        surface torsion 1e155 3 | `torsion 1e155 3` does not fit
        surface --command cat --region=0:1 --answer-seconds 1e300 | --answer-seconds 1e300
    ";
    for case in rows(cases) {
        assert_says(&desk.early_mistake(case[0]), &case[1..]);
    }
}

/// The error says that a path is no hand, no landscape or no place to write to.
#[test]
fn the_wrong_kind_of_file() {
    let desk = Desk::with_grasps();
    desk.write("ball.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    let sentence = desk.early_mistake("hands inspect ball.obj");
    assert_says(
        &sentence,
        &["ball.obj", "not a description of a hand", "URDF or MJCF"],
    );
    for line in [
        "diff g.parquet g.parquet",
        "draw g.parquet",
        "compare g.parquet",
    ] {
        let sentence = desk.early_mistake(line);
        assert_says(
            &sentence,
            &["g.parquet is a file", "a landscape is a folder"],
        );
    }
    fs::create_dir(desk.path("empty.landscape")).unwrap();
    let sentence = desk.early_mistake("build empty.landscape");
    assert_says(
        &sentence,
        &["empty.landscape is a folder", "a file is needed"],
    );
    if cfg!(target_os = "linux") {
        let sentence =
            desk.mistake("synth --object ball -n 1 --steps 1 --keep all -o /proc/x.parquet");
        assert_says(&sentence, &["no file can be made in /proc"]);
    }
}

#[test]
fn files_of_a_hand_go_where_they_are_asked_to() {
    let desk = Desk::empty();
    desk.succeed("hands inspect gripper_parallel -o mine");
    desk.succeed("hands inspect gripper_parallel -o other.png --side-file other.json");
    assert_eq!(
        names(desk.folder.path()),
        ["mine.png", "other.json", "other.png"]
    );
}

/// A side file beside a description is read with it, so a look at a hand must not leave one there.
#[test]
fn a_look_at_a_hand_leaves_its_derivation_free() {
    let desk = Desk::empty();
    let urdf = include_str!("../../python/tutorials/claw/claw.urdf");
    desk.write("my.urdf", urdf);
    desk.succeed("hands inspect my.urdf");
    assert_eq!(names(desk.folder.path()), ["my.png", "my.urdf"]);
    desk.succeed("hands inspect my.urdf");
    assert_eq!(names(desk.folder.path()), ["my.png", "my.urdf"]);
    desk.succeed("hands inspect my.urdf --side-file my.json");
    assert_says(
        &desk.succeed("hands inspect my.urdf"),
        &["my.json is read with it"],
    );
    let sentence = desk.early_mistake("hands inspect my.urdf --side-file my.json");
    assert_says(&sentence, &["my.json", "may have been edited"]);
}

/// A hand is called as in the file of its grasps, not as its description calls it.
#[test]
fn exports_name_the_hand_as_files_of_grasps_do() {
    let desk = Desk::empty();
    let urdf = include_str!("../../python/tutorials/claw/claw.urdf");
    desk.write("my.urdf", urdf);
    desk.succeed("synth --hand my.urdf --object ball -n 1 --steps 1 --keep all -q -o g.parquet");
    desk.succeed("export g.parquet urdf -o hand");
    let text = desk.text("hand/my.urdf");
    assert!(text.contains("<robot name=\"my\">"), "{text}");
}

#[test]
fn help_and_version() {
    let desk = Desk::empty();
    let text = |line: &str| desk.print(line);
    assert_says(&text("--help"), &["synth", "build", "Examples:"]);
    let bake = ["--specs", "--scale", "Examples:", "landscape objects bake "];
    assert_says(&text("objects bake --help"), &bake);
    assert_eq!(
        text("--version"),
        format!("landscape {}\n", env!("CARGO_PKG_VERSION"))
    );
    // Without arguments: the help, as an answer to a mistake.
    let output = desk.run("");
    assert_eq!(output.status.code(), Some(2));
    assert_says(
        &String::from_utf8(output.stderr).unwrap(),
        &["Usage: landscape"],
    );
}
