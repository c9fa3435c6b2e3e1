//! A folder in which the whole program runs.

use std::path::PathBuf;
use std::process::{Command, Output};

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

    pub(crate) fn command(&self, line: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_landscape"));
        command
            .args(line.split_whitespace())
            .current_dir(self.folder.path());
        command
    }

    pub(crate) fn run(&self, line: &str) -> Output {
        self.command(line).output().unwrap()
    }

    /// Runs a command that must fail with exit code 1, or 2 if clap refuses the command line, and one line `error: …`. Returns
    /// the message.
    pub(crate) fn mistake(&self, line: &str) -> String {
        let output = self.run(line);
        let said = String::from_utf8(output.stderr).unwrap();
        let usage = said.contains("For more information, try '--help'");
        let code = if usage { 2 } else { 1 };
        assert_eq!(output.status.code(), Some(code), "landscape {line}: {said}");
        assert!(!said.contains("panicked"), "{said}");
        let sentence = said.strip_prefix("error: ").expect(&said);
        assert!(!sentence.contains("error:"), "one error only: {said}");
        sentence.trim_end().to_owned()
    }
}

pub(crate) fn assert_says(sentence: &str, words: &[&str]) {
    for word in words {
        assert!(
            sentence.contains(word),
            "`{word}` is missing in: {sentence}"
        );
    }
}
