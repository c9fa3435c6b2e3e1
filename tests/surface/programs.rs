//! Energies of other programs: protocols, failures, spaces, and what is said of odd ones.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use landscape::store::StationaryRow;

use super::promised;
use crate::desk::{Desk, assert_says};
use crate::table::rows;

#[cfg(unix)]
#[test]
fn programs_that_fail_are_told() {
    let desk = Desk::empty();
    let cases = r#"
        exit 3 | ended (exit status: 3)
        no_such_program_anywhere | exit status: 127
        while read line; do echo hello; done | answered `hello`
        while read line; do echo '{"energy": NaN, "gradient": [0, 0]}'; done | must be finite
        while read line; do echo '{"energy": 1, "gradient": [5, 5]}'; done | the gradient is not the derivative
        while read line; do echo '{"energy": null}'; done | found no minimum
        read line; while :; do printf '[0, 0, 0, 0, 0, 0, 0, 0]'; done | a line has at most
        while read line; do echo '{"error": "no such atom"}'; done | reports: no such atom
    "#;
    for case in rows(cases) {
        let said = desk.unmapped(&format!(
            "--command `{}` --region=-1:1x2 -q -o out",
            case[0]
        ));
        assert_says(&said, &case[1..]);
    }
}

/// Whether a process still runs.
#[cfg(target_os = "linux")]
fn runs(process: &str) -> bool {
    let state = fs::read_to_string(format!("/proc/{process}/stat"));
    // A process that nobody has asked after yet is a zombie.
    state.is_ok_and(|state| !state.contains(") Z "))
}

#[cfg(target_os = "linux")]
#[test]
fn programs_end_with_the_run_however_it_ends() {
    // Others may be ignored where tests run in the background, and are then ignored by the run as well.
    for signal in ["KILL", "TERM"] {
        let desk = Desk::empty();
        // A program that does not care whether its input ends, and another that it started.
        let program = "sleep 600 & echo $! $$ > started.new; mv started.new started; trap '' HUP; read line; sleep 600; true";
        let mut run = desk
            .command(&format!("surface --command `{program}` --region=-1:1x2 -q"))
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let wait = |what: &dyn Fn() -> bool| {
            for _ in 0..2000 {
                if what() {
                    return true;
                }
                std::thread::sleep(Duration::from_millis(10));
            }
            false
        };
        assert!(
            wait(&|| desk.path("started").exists()),
            "{signal}: not started"
        );
        let started = desk.text("started");
        assert!(started.split_whitespace().all(runs), "{signal}: {started}");
        let kill = format!("kill -{signal} {}", run.id());
        let killed = Command::new("sh").args(["-c", &kill]).status().unwrap();
        assert!(killed.success());
        run.wait().unwrap();
        let ended = wait(&|| !started.split_whitespace().any(runs));
        assert!(ended, "{signal}: something of {started} still runs");
    }
}

/// Whether Python is available.
pub(crate) fn python() -> bool {
    let found = Command::new("python3").arg("--version").output();
    let there = found.is_ok_and(|output| output.status.success());
    if !there {
        crate::skipped::skipped("there is no python3");
    }
    there
}

const BROWN: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/data/energies/muller_brown.py");
const BROWN_BOX: &str = "--region=-1.5:1,-0.3:1.8 -q --patience 8";

#[test]
fn a_python_energy_is_mapped() {
    if !python() {
        return;
    }
    let desk = Desk::empty();
    let search = format!("--command `python3 '{BROWN}'` {BROWN_BOX}");
    desk.mapped(&format!("{search} --threads 2 -o one"));
    desk.mapped(&format!("{search} --threads 1 -o two"));
    assert_eq!(promised(&desk.path("one")), promised(&desk.path("two")));
    check_brown(&desk.path("one"));
}

/// The published minima and saddles of Müller and Brown's surface.
fn check_brown(folder: &Path) {
    let rows = StationaryRow::read(folder).unwrap();
    let known = [-146.699517, -108.166724, -80.767818, -72.248940, -40.664844];
    assert_eq!(rows.len(), known.len());
    for (row, known) in rows.iter().zip(known) {
        assert!((row.energy - known).abs() < 1e-5, "{row:?}");
    }
}

/// Waves in a periodic cell: one minimum, two saddles, and a maximum; their copies in other cells are the same points.
const WAVES: &str = r#"
import math, struct, sys
def answer(x, y):
    a, b = 2 * math.pi * (x - 0.3) / 3, 2 * math.pi * (y + 0.1) / 2
    value = -math.cos(a) - 0.5 * math.cos(b)
    return struct.pack("<3d", value, math.sin(a) * 2 * math.pi / 3, 0.5 * math.sin(b) * math.pi)
"#;

/// Answers to one point at a time.
const ONE: &str = r#"
while data := sys.stdin.buffer.read(16):
    sys.stdout.buffer.write(answer(*struct.unpack("<2d", data)))
    sys.stdout.buffer.flush()
"#;

/// Answers to many points at once.
const MANY: &str = r#"
counts = open("counts.txt", "a")
while header := sys.stdin.buffer.read(8):
    (count,) = struct.unpack("<Q", header)
    print(count, file=counts, flush=True)
    numbers = struct.unpack(f"<{2 * count}d", sys.stdin.buffer.read(16 * count))
    sys.stdout.buffer.write(b"".join(map(answer, numbers[::2], numbers[1::2])))
    sys.stdout.buffer.flush()
"#;

/// Maps the waves with a program of this loop.
fn waves(desk: &Desk, answers: &str, protocol: &str) -> Vec<StationaryRow> {
    desk.write("waves.py", format!("{WAVES}{answers}"));
    let output = format!("{protocol}.landscape");
    let search = "--command `python3 waves.py` --region=-1:2,0:2 --coordinates periodic -q";
    desk.mapped(&format!("{search} --protocol {protocol} -o {output}"));
    desk.stationary(&output)
}

#[test]
fn a_periodic_cell_is_mapped_in_plain_numbers() {
    if !python() {
        return;
    }
    let desk = Desk::empty();
    let rows = waves(&desk, ONE, "binary");
    let found: Vec<(u64, f64)> = rows.iter().map(|row| (row.index, row.energy)).collect();
    let expected = [(0, -1.5), (1, -0.5), (1, 0.5)];
    assert_eq!(found.len(), expected.len(), "{found:?}");
    for ((index, energy), (known, height)) in found.iter().zip(expected) {
        assert!(
            *index == known && (energy - height).abs() < 1e-9,
            "{found:?}"
        );
    }
    assert!((rows[0].coordinates[0] - 0.3).abs() < 1e-6, "{:?}", rows[0]);
    assert!((rows[0].coordinates[1] - 1.9).abs() < 1e-6, "{:?}", rows[0]);
}

#[test]
fn many_points_are_asked_for_at_once() {
    if !python() {
        return;
    }
    let desk = Desk::empty();
    let one = waves(&desk, ONE, "binary");
    let all = waves(&desk, MANY, "batch");
    assert_eq!(one.len(), all.len());
    for (one, all) in one.iter().zip(&all) {
        assert!((one.energy - all.energy).abs() < 1e-9 && one.index == all.index);
    }
    // Hessians ask for two points for each of two coordinates.
    let counts = desk.text("counts.txt");
    assert!(counts.lines().any(|line| line == "4") && counts.lines().any(|line| line == "1"));
}

#[test]
fn a_neural_network_is_mapped() {
    if !python() {
        return;
    }
    let desk = Desk::empty();
    let example = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/data/energies/neural_network.py"
    );
    let search = "--protocol binary --region=-3:3x9 --search all --searches 300 -q --no-report";
    desk.mapped(&format!(
        "--command `python3 '{example}'` {search} -o network.landscape"
    ));
    let rows = desk.stationary("network.landscape");
    let minima: Vec<&StationaryRow> = rows.iter().filter(|row| row.index == 0).collect();
    // The best network comes in copies: hidden units exchanged, signs turned.
    let best = minima
        .iter()
        .filter(|row| row.energy - minima[0].energy < 1e-6)
        .count();
    assert!(
        best > 1 && rows.len() > minima.len(),
        "{best} of {}",
        minima.len()
    );
    // It tells all four cases apart: a network that does not has a loss above ln 2/2.
    assert!(
        minima[0].energy < 0.5 * std::f64::consts::LN_2,
        "{}",
        minima[0].energy
    );
}

#[test]
fn a_python_energy_without_gradient_is_mapped() {
    if !python() {
        return;
    }
    let desk = Desk::empty();
    let program = fs::read_to_string(BROWN).unwrap();
    let program = program.replace(
        "\"energy\": energy, \"gradient\": gradient",
        "\"energy\": energy",
    );
    assert!(!program.contains("\"gradient\": gradient"));
    desk.write("brown.py", program);
    desk.mapped(&format!("--command `python3 brown.py` {BROWN_BOX} -o out"));
    check_brown(&desk.path("out"));
}

/// A Python program with the lines that compute `energy` and `gradient` from `x` and `y`.
pub(crate) fn program(desk: &Desk, name: &str, lines: &str) -> String {
    let text = format!(
        "import json, math, sys\nfor line in sys.stdin:\n    x, y = json.loads(line)['x']\n    {}\n    \
         print(json.dumps({{'energy': energy, 'gradient': gradient}}), flush=True)\n",
        lines.replace('\n', "\n    ")
    );
    desk.write(name, text);
    format!("python3 {name}")
}

#[test]
fn rings_and_kinks_are_told() {
    if !python() {
        return;
    }
    let desk = Desk::empty();
    let ring = program(
        &desk,
        "ring.py",
        "s = x * x + y * y - 1\nenergy = s * s\ngradient = [4 * s * x, 4 * s * y]",
    );
    let search = |command: &str| format!("--command `{command}` --region=-2:2x2 --patience 8");
    let said = desk.mapped(&format!("{} -o ring", search(&ring)));
    assert_says(
        &said,
        &[
            "**1 minimum** and **0 saddles**",
            "1 component; 1 family (relative barrier up to",
            "**1 of them is not isolated**",
            "1 minimum and 0 saddles are not isolated",
            "a walk along the level directions joins them",
            "| m0 (not isolated) |",
            "nothing is claimed, since rings",
        ],
    );
    let rows = desk.stationary("ring");
    assert!(
        rows.iter().all(|row| row.verdict == "degenerate"),
        "{rows:?}"
    );
    let cusp = program(
        &desk,
        "cusp.py",
        "x -= 0.2\nenergy = abs(x) + y * y\ngradient = [math.copysign(1, x), 2 * y]",
    );
    let said = desk.unmapped(&format!("{} -o cusp -q", search(&cusp)));
    assert_says(&said, &["found no minimum", "bottom of a kink"]);
    let ridge = program(
        &desk,
        "ridge.py",
        "s = 1 if x > -0.075 else -1\nenergy = (x - s) ** 2 + y * y + (0.3 if s < 0 else 0)\ngradient = [2 * (x - s), 2 * y]",
    );
    let said = desk.mapped(&format!("{} -o ridge", search(&ridge)));
    assert_says(
        &said,
        &[
            "joined to the others by no saddle\n",
            "no search ended at a saddle",
            "it lies on a kink, where it cannot be verified",
        ],
    );
    let told = desk.text("ridge/landscape.json");
    assert!(told.contains("\"unseen_below\": null"), "{told}");
}

#[test]
fn completeness_is_claimed_where_it_is_earned() {
    let desk = Desk::empty();
    let sure = desk.mapped("torsion 1 3 1 3");
    assert_says(
        &sure,
        &["completeness: **99 % sure** of all minima and saddles"],
    );
    let unsure = desk.mapped("lj 7");
    assert!(!unsure.contains("99 % sure"), "{unsure}");
    // What was stopped by one limit is not advised to raise the other.
    let stopped = desk.mapped("lj 7 --searches 64 -o stopped");
    assert_says(
        &stopped,
        &["nothing is claimed, since the search was stopped"],
    );
    assert!(stopped.contains("--searches allows more"), "{stopped}");
    assert!(!stopped.contains("--patience looks longer"), "{stopped}");
}

/// Declared copies are one minimum, and the saddles between them join it to itself.
#[test]
fn declared_symmetries_make_one_point_of_copies() {
    if !python() {
        return;
    }
    let desk = Desk::empty();
    let wells = program(
        &desk,
        "wells.py",
        "energy = (x * x - 1) ** 2 + (y * y - 1) ** 2\ngradient = [4 * x * (x * x - 1), 4 * y * (y * y - 1)]",
    );
    let search = format!("--command `{wells}` --region=-2:2x2 -q --patience 8");
    desk.mapped(&format!("{search} -o all"));
    desk.write("copies.txt", "# exchange, mirror\n2 1\n-1 2\n");
    let declared = "--symmetries copies.txt -o one";
    desk.mapped(&format!("{search} {declared}"));
    let counts = |name: &str| {
        let rows = desk.stationary(name);
        [0, 1].map(|index| rows.iter().filter(|row| row.index == index).count())
    };
    assert_eq!((counts("all"), counts("one")), ([4, 4], [1, 1]));
    // Of 8 symmetries the exchange (or its negative) leaves a minimum in place: 4 copies.
    let minima = desk.text("one/min.data");
    assert_eq!(minima.split_whitespace().nth(2), Some("2"), "{minima}");
    for (text, said) in [
        ("1 2\n-2 3\n", "does not name coordinate 1"),
        ("2 one\n", "line 1: `one` is not the number"),
        ("1 2 3\n", "has 3 numbers"),
        ("# none\n", "contains no symmetry"),
    ] {
        desk.write("copies.txt", text);
        let told = desk.unmapped(&format!("{search} {declared}"));
        assert!(told.contains(said), "{told}");
    }
    let tilted = program(
        &desk,
        "tilted.py",
        "energy = (x * x - 1) ** 2 + y * y + 0.1 * x\ngradient = [4 * x * (x * x - 1) + 0.1, 2 * y]",
    );
    desk.write("copies.txt", "1 -2\n-1 2\n");
    let told = desk.unmapped(&format!(
        "--command `{tilted}` --region=-2:2x2 -q {declared}"
    ));
    assert!(told.contains("symmetry 2 changes the energy"), "{told}");
}
