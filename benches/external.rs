//! Time that a question to another program costs beyond the program's own time: `cargo bench --bench external`.
//!
//! The program is a loop in Python that answers with constants. Its own time is measured by itself, on bytes in memory.

use std::fmt::Write;
use std::time::Instant;

use landscape::energy::{Energy, External, Protocol};
use landscape::space::Euclidean;

const DIMENSIONS: usize = 30;
const CALLS: usize = 20_000;

/// The loop, between `source` and `sink`.
const LOOP: &str = r#"
import io, json, struct, sys, time
n = 30
answer = {"energy": 1.0, "gradient": [0.5] * n}

def text(source, sink):
    while line := source.readline():
        json.loads(line)
        sink.write(json.dumps(answer).encode() + b"\n")
        sink.flush()

def binary(source, sink):
    question, numbers = struct.Struct(f"<{n}d"), struct.Struct(f"<{n + 1}d")
    while data := source.read(question.size):
        question.unpack(data)
        sink.write(numbers.pack(1.0, *answer["gradient"]))
        sink.flush()

def batch(source, sink):
    numbers = struct.Struct(f"<{n + 1}d")
    while header := source.read(8):
        (count,) = struct.unpack("<Q", header)
        struct.unpack(f"<{n * count}d", source.read(8 * n * count))
        sink.write(numbers.pack(1.0, *answer["gradient"]) * count)
        sink.flush()
"#;

/// Seconds of `calls` turns of the loop in memory.
fn own_time(name: &str, question: &str, calls: usize) -> f64 {
    let mut script = LOOP.to_owned();
    write!(
        script,
        "\nsource = io.BytesIO({question} * {calls})\nbegan = time.perf_counter()\n{name}(source, io.BytesIO())\nprint(time.perf_counter() - began)"
    )
    .expect("a string takes all text");
    let output = std::process::Command::new("python3")
        .args(["-c", &script])
        .output()
        .expect("python3 can be started");
    let text = String::from_utf8_lossy(&output.stdout);
    text.trim().parse().expect("the script prints a number")
}

fn main() {
    let folder = tempfile::tempdir().expect("a folder for the script");
    let x = vec![0.25; DIMENSIONS];
    let mut gradient = vec![0.0; DIMENSIONS];
    let mut hessian = vec![0.0; DIMENSIONS * DIMENSIONS];
    let points = 2 * DIMENSIONS;
    println!("| protocol | µs for each point | of these the program | overhead |");
    println!("|---|---|---|---|");
    let zeros = |count: usize| format!("bytes({})", 8 * DIMENSIONS * count);
    let line = format!("b'{{\"x\":{x:?}}}\\n'");
    for (name, protocol, question, points) in [
        ("text", Protocol::Json, line, 1),
        ("binary", Protocol::Binary, zeros(1), 1),
        (
            "batch",
            Protocol::Batch,
            format!("(struct.pack('<Q', {points}) + {})", zeros(points)),
            points,
        ),
    ] {
        let script = folder.path().join(format!("{name}.py"));
        let body = format!("{LOOP}\n{name}(sys.stdin.buffer, sys.stdout.buffer)\n");
        std::fs::write(&script, body).expect("the script can be written");
        let command = format!("exec python3 {}", script.display());
        let space = Box::new(Euclidean::new(DIMENSIONS));
        let external = External::start(&command, space, 1e-3)
            .expect("python3 can be started")
            .with_protocol(protocol);
        let calls = CALLS / points;
        let mut ask = || {
            if points > 1 {
                external.hessian(&x, &mut hessian);
            } else {
                external.evaluate(&x, &mut gradient);
            }
        };
        ask();
        let began = Instant::now();
        (0..calls).for_each(|_| ask());
        let whole = began.elapsed().as_secs_f64();
        external.check().expect("the program answers");
        let own = own_time(name, &question, calls);
        let micro = |seconds: f64| 1e6 * seconds / (calls * points) as f64;
        println!(
            "| {name} | {:.2} | {:.2} | {:.2} |",
            micro(whole),
            micro(own),
            micro(whole - own)
        );
    }
}
