//! An energy that another program computes.

use std::fmt;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use program::{Program, Silence, Supervisor};
use serde_json::json;
use text::{Misunderstood, read};

use super::{Energy, hessian_from_gradients};
use crate::space::Space;

mod answers;
mod guard;
mod program;
mod text;

/// Number of characters of an answer that an error quotes.
const QUOTED: usize = 80;
/// Longest line of an answer, bytes: a constant, and an amount for each number of the gradient.
const LONGEST: [u64; 2] = [1 << 16, 64];

/// An energy computed by another program, which exchanges lines of JSON over its standard input and output.
///
/// ```text
/// asked:     {"x": [0.5, -1.25]}
/// answered:  {"energy": 3.5, "gradient": [0.25, -1.0]}      the derivative along each tangent of the space
///            {"energy": null}                                outside the domain
///            {"error": "what is wrong"}                      ends the run
/// ```
///
/// Each question and each answer is one line, in turn, until the input ends. The program must flush after each answer. If
/// it leaves out the gradient, central differences replace it, at the cost of two questions per tangent. Programs are
/// started as threads need them, at most one per thread, and must give the same answer to the same question.
///
/// With [`Protocol::Binary`], questions and answers are plain numbers, which costs less per call.
///
/// An answer may take [`External::ANSWER_LIMIT`], or the limit of [`External::with_answer_limit`], and be one line of at
/// most 64 KiB and 64 bytes per tangent. When the value is dropped, the input of its programs is closed; two seconds later
/// they are stopped by force. On Unix each program leads its own process group, which ends with it, and also when this
/// process is killed by any signal.
///
/// An evaluation cannot fail, so the first failure is kept: from then on every energy is infinite, which soon ends a
/// search, and [`External::check`] returns the error.
pub struct External {
    command: String,
    protocol: Protocol,
    space: Box<dyn Space + Send>,
    difference: f64,
    answer_limit: Duration,
    idle: Mutex<Vec<Program>>,
    supervisor: Supervisor,
    differenced: AtomicBool,
    failure: Mutex<Option<ExternalError>>,
}

/// How a program is asked and answers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Protocol {
    /// Lines of JSON.
    #[default]
    Json,
    /// Numbers of 64 bits (IEEE 754, little-endian), without anything between them. A question is the n coordinates of a
    /// point. An answer is the energy and its derivative along each tangent; an energy that is not finite means a point
    /// outside the domain.
    Binary,
    /// As [`Protocol::Binary`] for many points at once. A question begins with the number of its points (an unsigned integer
    /// of 64 bits, little-endian), and the answers to its points follow one another in their order. The program must read
    /// the whole question before it answers. Hessians ask for all their gradients in one question.
    Batch,
}

/// A failure of another program.
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
        /// The question.
        question: String,
    },
    /// It did not answer in time.
    #[error(
        "`{command}` has not answered the question {question} within {seconds} s and was stopped"
    )]
    Late {
        /// The command.
        command: String,
        /// How long it may take.
        seconds: f64,
        /// The question.
        question: String,
    },
    /// Its answer has the wrong form.
    #[error("`{command}` answered `{answer}` to {question}: {complaint}")]
    Answer {
        /// The command.
        command: String,
        /// The beginning of its answer.
        answer: String,
        /// The question.
        question: String,
        /// What is wrong with the answer.
        complaint: String,
    },
    /// It reported an error of its own.
    #[error("`{command}` reports: {message} (asked {question})")]
    Reported {
        /// The command.
        command: String,
        /// Its message.
        message: String,
        /// The question.
        question: String,
    },
}

impl External {
    /// Default time limit of an answer.
    pub const ANSWER_LIMIT: Duration = Duration::from_mins(1);

    /// Starts `command` (given to the shell) on points of `space`. It asks no question yet.
    ///
    /// `difference` is the step of the central differences that replace a missing gradient.
    ///
    /// # Errors
    /// If the command cannot be started.
    pub fn start(
        command: &str,
        space: Box<dyn Space + Send>,
        difference: f64,
    ) -> Result<Self, ExternalError> {
        let failed = |source| ExternalError::Start {
            command: command.to_owned(),
            source: Arc::new(source),
        };
        let supervisor = Supervisor::start().map_err(failed)?;
        let program = supervisor.launch(command).map_err(failed)?;
        Ok(Self {
            command: command.to_owned(),
            protocol: Protocol::Json,
            space,
            difference,
            answer_limit: Self::ANSWER_LIMIT,
            idle: Mutex::new(vec![program]),
            supervisor,
            differenced: AtomicBool::new(false),
            failure: Mutex::new(None),
        })
    }

    /// Replaces the time limit of an answer.
    #[must_use]
    pub fn with_answer_limit(mut self, limit: Duration) -> Self {
        self.answer_limit = limit;
        self
    }

    /// Replaces the protocol.
    #[must_use]
    pub fn with_protocol(mut self, protocol: Protocol) -> Self {
        self.protocol = protocol;
        self
    }

    /// Checks that no program has failed so far.
    ///
    /// # Errors
    /// The first failure, if there was one.
    pub fn check(&self) -> Result<(), ExternalError> {
        lock(&self.failure).clone().map_or(Ok(()), Err)
    }

    /// Whether any answer so far lacked a gradient, which differences then replaced.
    pub fn is_differenced(&self) -> bool {
        self.differenced.load(Ordering::Relaxed)
    }

    /// Lets `ask` ask an idle program or a new one.
    fn with_program<T>(
        &self,
        ask: impl FnOnce(&mut Program) -> Result<T, ExternalError>,
    ) -> Result<T, ExternalError> {
        let idle = lock(&self.idle).pop();
        let mut program =
            match idle {
                Some(program) => program,
                None => self.supervisor.launch(&self.command).map_err(|source| {
                    ExternalError::Start {
                        command: self.command.clone(),
                        source: Arc::new(source),
                    }
                })?,
            };
        let answer = ask(&mut program)?;
        // A program that failed is not asked again.
        lock(&self.idle).push(program);
        Ok(answer)
    }

    /// What `ask` returns, or `None` after the first failure, which is kept.
    fn unless_failed<T>(
        &self,
        ask: impl FnOnce(&mut Program) -> Result<T, ExternalError>,
    ) -> Option<T> {
        if lock(&self.failure).is_some() {
            return None;
        }
        let answer = self.with_program(ask);
        answer
            .map_err(|error| lock(&self.failure).get_or_insert(error).clone())
            .ok()
    }

    fn converse(
        &self,
        program: &mut Program,
        x: &[f64],
        gradient: &mut [f64],
    ) -> Result<f64, ExternalError> {
        if self.protocol != Protocol::Json {
            let mut energies = [0.0];
            self.question_in_bytes(program, &[x.to_vec()], &mut energies, gradient)?;
            return Ok(energies[0]);
        }
        let (energy, given) = self.question(program, x)?;
        if let Some(given) = given {
            gradient.copy_from_slice(&given);
            return Ok(energy);
        }
        if !energy.is_finite() {
            return Ok(energy);
        }
        self.differenced.store(true, Ordering::Relaxed);
        let mut step = vec![0.0; gradient.len()];
        for (j, g) in gradient.iter_mut().enumerate() {
            let mut side = |length: f64| {
                let mut there = x.to_vec();
                step[j] = length;
                self.space.exp(&mut there, &step);
                step[j] = 0.0;
                self.question(program, &there)
            };
            let (ahead, behind) = (side(self.difference)?.0, side(-self.difference)?.0);
            *g = (ahead - behind) / (2.0 * self.difference);
            if !g.is_finite() {
                // Next to the edge of the domain the derivative does not exist.
                return Ok(f64::INFINITY);
            }
        }
        Ok(energy)
    }

    /// Asks one question and reads the answer: the energy, and the gradient if it is given.
    fn question(
        &self,
        program: &mut Program,
        x: &[f64],
    ) -> Result<(f64, Option<Vec<f64>>), ExternalError> {
        let question = json!({ "x": x }).to_string();
        let tangents = self.space.tangents();
        let longest = LONGEST[0] + LONGEST[1] * tangents as u64;
        let unlike = |answer: &[u8], complaint: String, question| ExternalError::Answer {
            command: self.command.clone(),
            answer: String::from_utf8_lossy(answer)
                .trim_end()
                .chars()
                .take(QUOTED)
                .collect(),
            question,
            complaint,
        };
        let answer = match program.exchange(&question, self.answer_limit, longest) {
            Ok(answer) => answer,
            Err(Silence::Long(beginning)) => {
                let complaint = format!("a line has at most {longest} bytes");
                return Err(unlike(&beginning, complaint, question));
            }
            Err(silence) => return Err(self.silent(program, &silence, question)),
        };
        read(&String::from_utf8_lossy(&answer), tangents).map_err(|fault| match fault {
            Misunderstood::Reported(message) => ExternalError::Reported {
                command: self.command.clone(),
                message,
                question,
            },
            Misunderstood::Complaint(complaint) => unlike(&answer, complaint, question),
        })
    }
}

impl External {
    /// Asks for the energies and gradients (one after the other) of `points` in a protocol of plain numbers. With
    /// [`Protocol::Binary`] there is one point.
    fn question_in_bytes(
        &self,
        program: &mut Program,
        points: &[Vec<f64>],
        energies: &mut [f64],
        gradients: &mut [f64],
    ) -> Result<(), ExternalError> {
        let tangents = self.space.tangents();
        let mut question = Vec::new();
        if self.protocol == Protocol::Batch {
            question.extend((points.len() as u64).to_le_bytes());
        }
        let numbers = points.iter().flatten();
        question.extend(numbers.flat_map(|number| number.to_le_bytes()));
        let mut answer = vec![0; size_of::<f64>() * points.len() * (1 + tangents)];
        (program.exchange_bytes(&question, &mut answer, self.answer_limit))
            .map_err(|silence| self.silent(program, &silence, json!(points[0]).to_string()))?;
        let mut numbers = answer.chunks_exact(size_of::<f64>()).map(|bytes| {
            f64::from_le_bytes(bytes.try_into().expect("a chunk has the size of a number"))
        });
        for (k, point) in points.iter().enumerate() {
            let gradient = &mut gradients[k * tangents..][..tangents];
            let energy = numbers.next().expect("every answer begins with the energy");
            for (slope, number) in gradient.iter_mut().zip(&mut numbers) {
                *slope = number;
            }
            energies[k] = if energy.is_finite() {
                energy
            } else {
                f64::INFINITY
            };
            if energy.is_finite() && gradient.iter().any(|slope| !slope.is_finite()) {
                return Err(ExternalError::Answer {
                    command: self.command.clone(),
                    answer: json!(gradient).to_string().chars().take(QUOTED).collect(),
                    question: json!(point).to_string(),
                    complaint: "the gradient of a finite energy must be finite".to_owned(),
                });
            }
        }
        Ok(())
    }

    /// The error of a program that does not answer.
    fn silent(&self, program: &mut Program, silence: &Silence, question: String) -> ExternalError {
        let command = self.command.clone();
        match silence {
            Silence::Late => ExternalError::Late {
                command,
                seconds: self.answer_limit.as_secs_f64(),
                question,
            },
            Silence::Ended | Silence::Long(_) => ExternalError::Ended {
                command,
                status: program.end(),
                question,
            },
        }
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
        if x.iter().any(|coordinate| !coordinate.is_finite()) {
            return f64::INFINITY;
        }
        self.unless_failed(|program| self.converse(program, x, gradient))
            .unwrap_or(f64::INFINITY)
    }

    /// With [`Protocol::Batch`], by central differences of gradients that are asked for in one question.
    fn hessian(&self, x: &[f64], hessian: &mut [f64]) -> bool {
        if self.protocol != Protocol::Batch {
            return false;
        }
        let gradients = |points: &[Vec<f64>]| {
            let finite = points.iter().flatten().all(|number| number.is_finite());
            let mut energies = vec![0.0; points.len()];
            let mut gradients = vec![0.0; points.len() * self.space.tangents()];
            let ask = |program: &mut Program| {
                self.question_in_bytes(program, points, &mut energies, &mut gradients)
            };
            (finite && self.unless_failed(ask).is_some() && energies.iter().all(|e| e.is_finite()))
                .then_some(gradients)
        };
        hessian_from_gradients(&*self.space, x, self.difference, gradients, hessian)
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

/// Locks a mutex, also after a panic: the data are always consistent when a lock is released.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
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

    /// A program that answers every two numbers with three, given as bytes for `printf`.
    fn in_bytes(answer: &str) -> External {
        let script = format!(
            "while dd bs=16 count=1 iflag=fullblock 2>/dev/null | grep -qc ''; do printf '{answer}'; done"
        );
        answering(&script).with_protocol(Protocol::Binary)
    }

    #[test]
    fn numbers_are_exchanged_as_they_are() {
        // 3.5, 0.25 and -2 as 64-bit numbers.
        let [energy, slopes] = [
            r"\000\000\000\000\000\000\014\100",
            r"\000\000\000\000\000\000\320\077\000\000\000\000\000\000\000\300",
        ];
        let external = in_bytes(&format!("{energy}{slopes}"));
        let mut gradient = [0.0; 2];
        for _ in 0..3 {
            assert!((external.evaluate(&[0.5, 1.0], &mut gradient) - 3.5).abs() < 1e-15);
            assert!((gradient[0] - 0.25).abs() < 1e-15 && (gradient[1] + 2.0).abs() < 1e-15);
        }
        // NaN means outside of the domain, but a finite energy needs a finite gradient.
        let nan = r"\000\000\000\000\000\000\370\177";
        let outside = in_bytes(&format!("{nan}{slopes}"));
        assert!(outside.evaluate(&[0.5, 1.0], &mut gradient).is_infinite());
        assert!(outside.check().is_ok());
        let broken = in_bytes(&format!("{energy}{nan}{nan}"));
        assert!(broken.evaluate(&[0.5, 1.0], &mut gradient).is_infinite());
        let told = broken.check().unwrap_err().to_string();
        assert!(
            told.contains("must be finite") && told.contains("[0.5,1.0]"),
            "{told}"
        );
        let gone = answering("exit 3").with_protocol(Protocol::Binary);
        assert!(gone.evaluate(&[0.5, 1.0], &mut gradient).is_infinite());
        assert!(
            gone.check()
                .unwrap_err()
                .to_string()
                .contains("exit status: 3")
        );
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
    fn an_answer_has_a_time_limit() {
        // Neither a program that thinks for ever nor one that never reads is waited for; the shell's child ends, too.
        for script in ["read line; sleep 1000; true", "sleep 1000; true"] {
            let limit = Duration::from_millis(200);
            let external = answering(script).with_answer_limit(limit);
            assert!(external.evaluate(&[0.5, 1.0], &mut [0.0; 2]).is_infinite());
            let sentence = external.check().unwrap_err().to_string();
            assert!(sentence.contains("within 0.2 s"), "{sentence}");
            assert!(sentence.contains(r#"{"x":[0.5,1.0]}"#), "{sentence}");
        }
    }

    #[test]
    fn a_line_has_an_end() {
        let sentence =
            failure("read line; while :; do printf '[0, 0, 0, 0, 0, 0, 0, 0, 0, 0, '; done");
        assert!(sentence.contains("at most 65664 bytes"), "{sentence}");
        assert!(sentence.len() < 300, "{sentence}");
        // What is no text is no answer either.
        let sentence = failure(r"while read line; do printf '\377\376\n'; done");
        assert!(sentence.contains("is expected"), "{sentence}");
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
