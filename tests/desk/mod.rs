//! A folder in which the whole program runs.

use std::fs;
use std::path::PathBuf;
use std::process::{Command, Output};

pub(crate) use crate::table::assert_says;
use landscape::store::{GraspFile, LandscapeFiles, Overrides};
use serde_json::Value;
use tempfile::TempDir;

/// A temporary folder.
pub(crate) struct Desk {
    pub(crate) folder: TempDir,
}

impl Desk {
    pub(crate) fn empty() -> Self {
        Self {
            folder: TempDir::new().unwrap(),
        }
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub(crate) fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        fs::write(self.path(name), content).unwrap();
    }

    pub(crate) fn bytes(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    pub(crate) fn text(&self, name: &str) -> String {
        String::from_utf8(self.bytes(name)).unwrap()
    }

    pub(crate) fn json(&self, name: &str) -> Value {
        serde_json::from_slice(&self.bytes(name)).unwrap()
    }

    pub(crate) fn grasps(&self, name: &str) -> GraspFile {
        let read = GraspFile::read(&self.path(name), Overrides::default());
        read.unwrap().0
    }

    pub(crate) fn landscape(&self, name: &str) -> LandscapeFiles {
        LandscapeFiles::read(&self.path(name)).unwrap()
    }

    /// The program with these words as arguments. A word with spaces is in backquotes.
    pub(crate) fn command(&self, line: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_landscape"));
        command.current_dir(self.folder.path());
        for (place, part) in line.split('`').enumerate() {
            match place % 2 {
                0 => command.args(part.split_whitespace()),
                _ => command.arg(part),
            };
        }
        command
    }

    pub(crate) fn run(&self, line: &str) -> Output {
        self.command(line).output().unwrap()
    }

    /// Runs a command that must succeed and returns what it prints, and what it says on standard error.
    pub(crate) fn both(&self, line: &str) -> (String, String) {
        let output = self.run(line);
        let [told, said] =
            [output.stdout, output.stderr].map(|text| String::from_utf8(text).unwrap());
        assert!(output.status.success(), "landscape {line}: {said}");
        (told, said)
    }

    /// Runs a command that must succeed and returns its standard error.
    pub(crate) fn succeed(&self, line: &str) -> String {
        self.both(line).1
    }

    /// Runs a command that must succeed and returns what it prints.
    pub(crate) fn print(&self, line: &str) -> String {
        self.both(line).0
    }

    /// Runs a command that must succeed and returns the JSON that it prints.
    pub(crate) fn document(&self, line: &str) -> Value {
        serde_json::from_str(&self.print(line)).unwrap()
    }

    /// Runs a command that must fail and says nothing but `error: …`. Returns the message.
    pub(crate) fn mistake(&self, line: &str) -> String {
        mistake(&self.run(line), line)
    }
}

/// The standard error of a command that failed with exit code 1, or 2 if clap refuses the command line, and one error.
pub(crate) fn failure(output: &Output, line: &str) -> String {
    let said = String::from_utf8(output.stderr.clone()).unwrap();
    let usage = said.contains("For more information, try '--help'");
    let code = if usage { 2 } else { 1 };
    assert_eq!(output.status.code(), Some(code), "landscape {line}: {said}");
    assert!(!said.contains("panicked"), "{said}");
    assert_eq!(said.matches("error:").count(), 1, "one error only: {said}");
    said
}

/// The message of a command that failed, as [`Desk::mistake`] requires it.
pub(crate) fn mistake(output: &Output, line: &str) -> String {
    let said = failure(output, line);
    let sentence = said.strip_prefix("error: ").expect(&said);
    sentence.trim_end().to_owned()
}
