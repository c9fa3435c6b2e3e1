//! An energy that another program computes.

use std::fmt;
use std::io::{BufRead, BufReader, Write};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use super::Energy;
use crate::space::Space;

/// How long a program may take to end once its input is closed.
const PATIENCE: Duration = Duration::from_secs(2);
/// Characters of an answer that an error repeats.
const QUOTED: usize = 80;

/// An energy that another program computes, spoken to in lines of JSON over its standard input and output.
///
/// ```text
/// asked:     {"x": [0.5, -1.25]}
/// answered:  {"energy": 3.5, "gradient": [0.25, -1.0]}      the derivative along each tangent of the space
///            {"energy": null}                                outside the domain
///            {"error": "what is wrong"}                      ends the run
/// ```
///
/// One question a line, one answer a line, in turn, until the input ends; the program must flush after each answer. The
/// gradient may be left out: then it is taken by central differences, at the price of two questions a tangent. Programs
/// are started as threads need them, at most one a thread, and must answer the same question alike.
///
/// An evaluation cannot fail, so the first failure is kept: from then on every energy is infinite, which ends a search
/// soon, and [`External::check`] tells what happened.
pub struct External {
    command: String,
    space: Box<dyn Space + Send>,
    difference: f64,
    idle: Mutex<Vec<Program>>,
    failure: Mutex<Option<ExternalError>>,
}

/// What another program did wrong.
#[derive(Debug, Clone, thiserror::Error)]
#[non_exhaustive]
pub enum ExternalError {
    /// It could not be started.
    #[error("cannot start `{command}`")]
    Start {
        /// The command.
        command: String,
        /// Why.
        source: Arc<std::io::Error>,
    },
    /// It ended or closed its output instead of answering.
    #[error("`{command}` ended ({status}) instead of answering the question {question}")]
    Ended {
        /// The command.
        command: String,
        /// How it ended.
        status: String,
        /// The line it was to answer.
        question: String,
    },
    /// Its answer cannot be understood.
    #[error("`{command}` answered `{answer}` to {question}: {complaint}")]
    Answer {
        /// The command.
        command: String,
        /// The beginning of its answer.
        answer: String,
        /// The line it answered.
        question: String,
        /// What is wrong with the answer.
        complaint: String,
    },
    /// It reported an error of its own.
    #[error("`{command}` reports: {message} (asked {question})")]
    Reported {
        /// The command.
        command: String,
        /// What it says.
        message: String,
        /// The line it was asked.
        question: String,
    },
}

impl External {
    /// Starts `command` (given to the shell) on points of `space`, and asks it nothing yet.
    ///
    /// `difference` is the length over which energies are differenced where the program gives no gradient.
    ///
    /// # Errors
    /// If the command cannot be started.
    pub fn start(
        command: &str,
        space: Box<dyn Space + Send>,
        difference: f64,
    ) -> Result<Self, ExternalError> {
        let external = Self {
            command: command.to_owned(),
            space,
            difference,
            idle: Mutex::new(Vec::new()),
            failure: Mutex::new(None),
        };
        let program = external.launch()?;
        lock(&external.idle).push(program);
        Ok(external)
    }

    /// Whether all answers were good so far.
    ///
    /// # Errors
    /// What went wrong first, if anything did.
    pub fn check(&self) -> Result<(), ExternalError> {
        lock(&self.failure).clone().map_or(Ok(()), Err)
    }

    fn launch(&self) -> Result<Program, ExternalError> {
        let started = shell(&self.command)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn();
        let failed = |source| ExternalError::Start {
            command: self.command.clone(),
            source: Arc::new(source),
        };
        let mut child = started.map_err(failed)?;
        let pipes = child.stdin.take().zip(child.stdout.take());
        let (input, output) = pipes.expect("both ends were asked for");
        Ok(Program {
            child,
            input: Some(input),
            output: BufReader::new(output),
        })
    }

    /// Energy at `x`, with an idle program or a new one.
    fn ask(&self, x: &[f64], gradient: &mut [f64]) -> Result<f64, ExternalError> {
        let idle = lock(&self.idle).pop();
        let mut program = match idle {
            Some(program) => program,
            None => self.launch()?,
        };
        let energy = self.converse(&mut program, x, gradient)?;
        // A program that failed is not asked again.
        lock(&self.idle).push(program);
        Ok(energy)
    }

    fn converse(
        &self,
        program: &mut Program,
        x: &[f64],
        gradient: &mut [f64],
    ) -> Result<f64, ExternalError> {
        let (energy, given) = self.question(program, x)?;
        if let Some(given) = given {
            gradient.copy_from_slice(&given);
            return Ok(energy);
        }
        if !energy.is_finite() {
            return Ok(energy);
        }
        let mut step = vec![0.0; gradient.len()];
        for (j, g) in gradient.iter_mut().enumerate() {
            let mut side = |length: f64| {
                let mut there = x.to_vec();
                step[j] = length;
                self.space.shift(&mut there, &step);
                step[j] = 0.0;
                self.question(program, &there)
            };
            let (ahead, behind) = (side(self.difference)?.0, side(-self.difference)?.0);
            *g = (ahead - behind) / (2.0 * self.difference);
            if !g.is_finite() {
                // Next to the edge of the domain there is no derivative to be had.
                return Ok(f64::INFINITY);
            }
        }
        Ok(energy)
    }

    /// One question and its answer: the energy, and the gradient if it is given.
    fn question(
        &self,
        program: &mut Program,
        x: &[f64],
    ) -> Result<(f64, Option<Vec<f64>>), ExternalError> {
        let question = json!({ "x": x }).to_string();
        let Some(answer) = program.exchange(&question) else {
            return Err(ExternalError::Ended {
                command: self.command.clone(),
                status: program.end(),
                question,
            });
        };
        read(&answer, self.space.tangents()).map_err(|fault| match fault {
            Misunderstood::Reported(message) => ExternalError::Reported {
                command: self.command.clone(),
                message,
                question,
            },
            Misunderstood::Complaint(complaint) => ExternalError::Answer {
                command: self.command.clone(),
                answer: answer.trim_end().chars().take(QUOTED).collect(),
                question,
                complaint,
            },
        })
    }
}

impl Energy for External {
    fn space(&self) -> &dyn Space {
        &*self.space
    }

    fn evaluate(&self, x: &[f64], gradient: &mut [f64]) -> f64 {
        let tangents = self.space.tangents();
        assert_eq!(
            (x.len(), gradient.len()),
            (self.space.coordinates(), tangents)
        );
        let broken = lock(&self.failure).is_some();
        if broken || x.iter().any(|coordinate| !coordinate.is_finite()) {
            return f64::INFINITY;
        }
        match self.ask(x, gradient) {
            Ok(energy) => energy,
            Err(error) => {
                lock(&self.failure).get_or_insert(error);
                f64::INFINITY
            }
        }
    }
}

impl fmt::Debug for External {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter
            .debug_struct("External")
            .field("command", &self.command)
            .finish_non_exhaustive()
    }
}

/// What is held by a lock is whole whenever it is released, whoever panicked.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

fn shell(command: &str) -> Command {
    let (shell, flag) = if cfg!(windows) {
        ("cmd", "/C")
    } else {
        ("sh", "-c")
    };
    let mut shell = Command::new(shell);
    shell.arg(flag).arg(command);
    shell
}

/// A running program.
struct Program {
    child: Child,
    input: Option<ChildStdin>,
    output: BufReader<ChildStdout>,
}

impl Program {
    /// Sends a line and waits for one; `None` if there is nobody to talk to any more.
    fn exchange(&mut self, question: &str) -> Option<String> {
        let input = self.input.as_mut()?;
        writeln!(input, "{question}")
            .and_then(|()| input.flush())
            .ok()?;
        let mut answer = String::new();
        let length = self.output.read_line(&mut answer);
        length.is_ok_and(|length| length > 0).then_some(answer)
    }

    /// Closes the input, waits for the end, by force if need be, and tells how it came.
    fn end(&mut self) -> String {
        self.input = None;
        let deadline = Instant::now() + PATIENCE;
        while Instant::now() < deadline {
            match self.child.try_wait() {
                Ok(Some(status)) => return status.to_string(),
                Ok(None) => std::thread::sleep(Duration::from_millis(2)),
                Err(error) => return error.to_string(),
            }
        }
        let killed = self.child.kill().and_then(|()| self.child.wait());
        killed.map_or_else(
            |error| error.to_string(),
            |_| "its output was closed, and it had to be stopped".to_owned(),
        )
    }
}

impl Drop for Program {
    fn drop(&mut self) {
        self.end();
    }
}

/// Why an answer is none.
enum Misunderstood {
    Reported(String),
    Complaint(String),
}

/// Energy and gradient of an answer on a space of so many tangents.
fn read(answer: &str, tangents: usize) -> Result<(f64, Option<Vec<f64>>), Misunderstood> {
    let complain = |text: String| Err(Misunderstood::Complaint(text));
    let expected =
        format!("a line {{\"energy\": number, \"gradient\": [{tangents} numbers]}} is expected");
    let Ok(Value::Object(answer)) = serde_json::from_str(answer) else {
        let finite = !["NaN", "nan", "Infinity", "inf"]
            .iter()
            .any(|word| answer.contains(word));
        return complain(if finite {
            expected
        } else {
            "numbers must be finite; outside the domain answer {\"energy\": null}".to_owned()
        });
    };
    if let Some(message) = answer.get("error") {
        let text = message
            .as_str()
            .map_or_else(|| message.to_string(), str::to_owned);
        return Err(Misunderstood::Reported(text));
    }
    let energy = match answer.get("energy") {
        Some(Value::Null) => return Ok((f64::INFINITY, Some(vec![0.0; tangents]))),
        Some(Value::Number(number)) => number.as_f64(),
        _ => None,
    };
    let Some(energy) = energy else {
        return complain(expected);
    };
    let Some(gradient) = answer.get("gradient") else {
        return Ok((energy, None));
    };
    let numbers = gradient
        .as_array()
        .map(|list| list.iter().filter_map(Value::as_f64).collect());
    let numbers: Vec<f64> = numbers.unwrap_or_default();
    if numbers.len() != tangents || gradient.as_array().map(Vec::len) != Some(tangents) {
        return complain(expected);
    }
    Ok((energy, Some(numbers)))
}

#[cfg(test)]
#[cfg(unix)]
mod tests {
    use super::*;
    use crate::space::Euclidean;

    fn answering(script: &str) -> External {
        External::start(script, Box::new(Euclidean::new(2)), 1e-4).unwrap()
    }

    /// The first failure of a program, after three questions at once.
    fn failure(script: &str) -> String {
        let external = answering(script);
        let mut gradient = [0.0; 2];
        for _ in 0..3 {
            external.evaluate(&[0.5, 1.0], &mut gradient);
        }
        assert!(external.evaluate(&[0.0, 0.0], &mut gradient).is_infinite());
        external.check().unwrap_err().to_string()
    }

    fn saying(answer: &str) -> String {
        format!("while read line; do echo '{answer}'; done")
    }

    #[test]
    fn energies_and_gradients_are_read() {
        let external = answering(&saying(r#"{"energy": 3.5, "gradient": [0.25, -1e-3]}"#));
        let mut gradient = [0.0; 2];
        assert!((external.evaluate(&[0.5, 1.0], &mut gradient) - 3.5).abs() < 1e-15);
        assert!((gradient[0] - 0.25).abs() + (gradient[1] + 1e-3).abs() < 1e-15);
        assert!(external.check().is_ok());
        let outside = answering(&saying(r#"{"energy": null}"#));
        assert!(outside.evaluate(&[0.5, 1.0], &mut gradient).is_infinite());
        assert!(outside.check().is_ok());
    }

    #[test]
    fn a_missing_gradient_is_differenced() {
        // 1 at the first question, 2 ahead of it and 1 behind it along the first tangent, then 4 and 8.
        let script = r#"for e in 1 2 1 4 8; do read line; echo "{\"energy\": $e}"; done"#;
        let external = answering(script);
        let mut gradient = [0.0; 2];
        let energy = external.evaluate(&[0.5, 1.0], &mut gradient);
        assert!((energy - 1.0).abs() < 1e-15, "{:?}", external.check());
        assert!((gradient[0] - 5e3).abs() < 1e-9 && (gradient[1] + 2e4).abs() < 1e-9);
    }

    #[test]
    fn failures_are_sentences() {
        let sentence = failure("read line; exit 3");
        assert!(sentence.contains("ended (exit status: 3)"), "{sentence}");
        assert!(sentence.contains(r#"{"x":[0.5,1.0]}"#), "{sentence}");
        let sentence = failure("no_such_program_anywhere 2>/dev/null");
        assert!(sentence.contains("exit status: 127"), "{sentence}");
        for (answer, part) in [
            ("hello", "is expected"),
            ("[1.0]", "is expected"),
            (r#"{"energy": "low", "gradient": [0, 0]}"#, "is expected"),
            (r#"{"energy": 1.0, "gradient": [0.0]}"#, "[2 numbers]"),
            (r#"{"energy": 1.0, "gradient": [0.0, null]}"#, "[2 numbers]"),
            (
                r#"{"energy": NaN, "gradient": [0.0, 0.0]}"#,
                "must be finite",
            ),
            (
                r#"{"energy": 1.0, "gradient": [Infinity, 0.0]}"#,
                "must be finite",
            ),
            (r#"{"error": "no such atom"}"#, "reports: no such atom"),
        ] {
            let sentence = failure(&saying(answer));
            assert!(sentence.contains(part), "{sentence}");
        }
    }

    #[test]
    fn one_program_a_thread() {
        let external = answering(&saying(r#"{"energy": 1.0, "gradient": [0.0, 0.0]}"#));
        std::thread::scope(|scope| {
            for _ in 0..3 {
                scope.spawn(|| {
                    for _ in 0..50 {
                        external.evaluate(&[0.0, 0.0], &mut [0.0; 2]);
                    }
                });
            }
        });
        let programs = lock(&external.idle).len();
        assert!((1..=3).contains(&programs), "{programs}");
        assert!(external.check().is_ok());
    }
}
