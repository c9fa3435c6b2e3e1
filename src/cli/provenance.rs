//! The command that recreates a file. It is taken from the whole parsed command line, so that no flag is forgotten.
//!
//! All given arguments are recorded in the order of the definition, except those that change no byte of the output. Only
//! the names of files and folders are recorded, not their places or how the paths were typed; the command recreates the
//! file in a folder that contains them. Hashes identify their contents ([`Provenance::sources`]).

use std::ffi::{OsStr, OsString};
use std::fmt::Write;
use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::parser::ValueSource;
use clap::{Arg, ArgMatches, Command, ValueHint};

use crate::hand::HAND_NAMES;
use crate::object::OBJECT_NAMES;
use crate::store::{Source, content_hash};

/// Arguments that change no byte of what is written: speed, verbosity, patience, overwriting, resuming, names, whether there
/// is a page and it is opened, and how many grasps are dropped after they are written.
const WITHOUT_TRACE: [&str; 14] = [
    "threads",
    "task",
    "log_format",
    "quiet",
    "json",
    "verbose",
    "force",
    "answer_seconds",
    "resume",
    "fresh",
    "output",
    "no_report",
    "open",
    "drop",
];

/// The command line of this process, as recorded in files.
#[derive(Debug, Clone, Default)]
pub(super) struct Provenance {
    /// The command line that recreates the output.
    pub(super) command: String,
    /// Name in the command and path of each input file and folder.
    inputs: Vec<(OsString, PathBuf)>,
}

impl Provenance {
    /// Takes the given arguments; `definition` must be built.
    pub(super) fn of(definition: &Command, matches: &ArgMatches) -> Self {
        let (verbs, given) = given(definition, matches);
        let paths: Vec<PathBuf> = given
            .iter()
            .flat_map(|(arg, occurrences)| {
                let values = occurrences.iter().flatten();
                values
                    .filter(|value| is_path(arg, value))
                    .map(|value| whole(value))
            })
            .collect();
        let names = names(&paths);
        let inputs: Vec<(OsString, PathBuf)> = names
            .into_iter()
            .map(PathBuf::into_os_string)
            .zip(paths)
            .collect();
        let mut next = inputs.iter().map(|(name, _)| name.clone());
        let mut words = verbs;
        for (arg, occurrences) in given {
            for values in occurrences {
                let recorded: Vec<OsString> = values
                    .into_iter()
                    .map(|value| {
                        if is_path(arg, &value) {
                            next.next().unwrap_or(value)
                        } else {
                            value
                        }
                    })
                    .collect();
                words.extend(spelled(arg, recorded));
            }
        }
        let command = words.join(" ");
        Self { command, inputs }
    }

    /// The input files with hashes of their bytes. Folders and inputs that can be read only once are left out.
    ///
    /// # Errors
    /// If a file cannot be read.
    pub(super) fn sources(&self) -> anyhow::Result<Vec<Source>> {
        let files = self.inputs.iter().filter(|(_, path)| path.is_file());
        files
            .map(|(name, path)| {
                let bytes = std::fs::read(path)
                    .with_context(|| format!("cannot read {}", path.display()))?;
                Ok(Source {
                    name: name.to_string_lossy().into_owned(),
                    content_hash: content_hash(&[&bytes]),
                })
            })
            .collect()
    }
}

/// The values of each occurrence of an argument.
type Occurrences = Vec<Vec<OsString>>;

/// Program and subcommands, and the given arguments of the last one, positional ones first.
fn given<'a>(
    definition: &'a Command,
    matches: &ArgMatches,
) -> (Vec<String>, Vec<(&'a Arg, Occurrences)>) {
    let (mut command, mut matches) = (definition, matches);
    let mut verbs = vec![command.get_name().to_owned()];
    while let Some((name, of_it)) = matches.subcommand()
        && let Some(subcommand) = command.find_subcommand(name)
    {
        verbs.push(name.to_owned());
        (command, matches) = (subcommand, of_it);
    }
    let is_given = |arg: &&Arg| {
        let id = arg.get_id().as_str();
        !WITHOUT_TRACE.contains(&id) && matches.value_source(id) == Some(ValueSource::CommandLine)
    };
    let flags = command.get_arguments().filter(|arg| !arg.is_positional());
    let arguments = command.get_positionals().chain(flags).filter(is_given);
    let occurrences = |arg: &Arg| {
        let all = matches.get_raw_occurrences(arg.get_id().as_str());
        all.into_iter()
            .flatten()
            .map(|values| values.map(OsStr::to_owned).collect())
            .collect()
    };
    let arguments = arguments.map(|arg| (arg, occurrences(arg))).collect();
    (verbs, arguments)
}

/// Whether a value names a file or folder, rather than a built-in hand or object.
fn is_path(arg: &Arg, value: &OsStr) -> bool {
    match arg.get_value_hint() {
        ValueHint::AnyPath => true,
        ValueHint::FilePath => {
            let names = HAND_NAMES.iter().chain(OBJECT_NAMES.iter());
            !names.into_iter().any(|name| OsStr::new(name) == value)
        }
        _ => false,
    }
}

fn spelled(arg: &Arg, mut values: Vec<OsString>) -> Vec<String> {
    if arg.is_positional() {
        let not_a_flag = |value: OsString| {
            if starts_with_dash(&value) && is_path(arg, &value) {
                Path::new(".").join(value).into_os_string()
            } else {
                value
            }
        };
        return values
            .into_iter()
            .map(|value| quoted(&not_a_flag(value)))
            .collect();
    }
    let long = arg.get_long().map(|name| format!("--{name}"));
    let short = arg.get_short().map(|name| format!("-{name}"));
    let flag = short.or(long.clone()).unwrap_or_default();
    if !arg.get_action().takes_values() {
        return vec![flag];
    }
    if let Some(delimiter) = arg.get_value_delimiter() {
        values = vec![values.join(OsStr::new(&delimiter.to_string()))];
    }
    match values.as_slice() {
        // Without `=` the value would be taken for a flag.
        [value] if starts_with_dash(value) => {
            vec![format!("{}={}", long.unwrap_or(flag), quoted(value))]
        }
        values => std::iter::once(flag)
            .chain(values.iter().map(|value| quoted(value)))
            .collect(),
    }
}

fn starts_with_dash(value: &OsStr) -> bool {
    value.as_encoded_bytes().starts_with(b"-")
}

/// The absolute path. A link as last component is kept, because its name was given.
fn whole(path: &OsStr) -> PathBuf {
    let path = Path::new(path);
    let real = |path: &Path| {
        path.canonicalize()
            .or_else(|_| std::path::absolute(path))
            .unwrap_or_else(|_| path.to_owned())
    };
    match (path.parent(), path.file_name()) {
        (Some(folder), Some(name)) if folder.as_os_str().is_empty() => {
            real(Path::new(".")).join(name)
        }
        (Some(folder), Some(name)) => real(folder).join(name),
        _ => real(path),
    }
}

/// Names of these paths in a command: as many last components as distinguish them, or relative to a listed folder.
fn names(paths: &[PathBuf]) -> Vec<PathBuf> {
    let folder = |path: &PathBuf| {
        let around = paths.iter().filter(|other| path.starts_with(other));
        around
            .min_by_key(|other| other.components().count())
            .cloned()
            .unwrap_or_else(|| path.clone())
    };
    let bases: Vec<PathBuf> = paths.iter().map(folder).collect();
    let deepest = bases.iter().map(|base| base.components().count()).max();
    let tails_of =
        |count: usize| -> Vec<PathBuf> { bases.iter().map(|base| tail(base, count)).collect() };
    let distinct = |tails: &[PathBuf]| {
        (0..bases.len()).all(|i| (0..i).all(|j| bases[i] == bases[j] || tails[i] != tails[j]))
    };
    let tails = (1..=deepest.unwrap_or(1))
        .map(tails_of)
        .find(|tails| distinct(tails))
        .unwrap_or_else(|| bases.clone());
    paths
        .iter()
        .zip(bases.iter().zip(tails))
        .map(|(path, (base, tail))| match path.strip_prefix(base) {
            Ok(rest) if rest != Path::new("") => tail.join(rest),
            _ => tail,
        })
        .collect()
}

fn tail(path: &Path, count: usize) -> PathBuf {
    let components: Vec<_> = path.components().collect();
    components[components.len().saturating_sub(count)..]
        .iter()
        .collect()
}

/// Quotes a word for the shell: plain, in single quotes, or as `$'…'` if it has unprintable characters.
fn quoted(word: &OsStr) -> String {
    let plain = |c: char| c.is_alphanumeric() || "-_./=:,+@%".contains(c);
    match word.to_str() {
        Some(text) if !text.is_empty() && text.chars().all(plain) => text.to_owned(),
        Some(text) if !text.chars().any(char::is_control) => {
            format!("'{}'", text.replace('\'', r"'\''"))
        }
        _ => {
            let mut escaped = String::new();
            for chunk in word.as_encoded_bytes().utf8_chunks() {
                for c in chunk.valid().chars() {
                    match c {
                        '\'' | '\\' => escaped.extend(['\\', c]),
                        c if c.is_control() => {
                            let mut bytes = [0; 4];
                            push_octal(&mut escaped, c.encode_utf8(&mut bytes).as_bytes());
                        }
                        c => escaped.push(c),
                    }
                }
                push_octal(&mut escaped, chunk.invalid());
            }
            format!("$'{escaped}'")
        }
    }
}

/// Appends bytes in the form that the shell reads in `$'…'`.
fn push_octal(text: &mut String, bytes: &[u8]) {
    for byte in bytes {
        let _ = write!(text, "\\{byte:03o}");
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::definition;

    fn recorded(line: &[&str]) -> String {
        let mut definition = definition();
        let line = [&["landscape"], line].concat();
        let matches = definition.try_get_matches_from_mut(line).unwrap();
        Provenance::of(&definition, &matches).command
    }

    #[test]
    fn commands_name_what_was_given() {
        for (line, expected) in [
            (
                &[
                    "synth",
                    "--seed",
                    "3",
                    "--object",
                    "/a/b/mug.obj",
                    "-n",
                    "4",
                    "--drop",
                    "0",
                    "-q",
                ][..],
                "landscape synth --object mug.obj -n 4 --seed 3",
            ),
            (
                &[
                    "synth",
                    "--object=./-b c.obj",
                    "--hand",
                    "human",
                    "-o",
                    "x.parquet",
                ],
                "landscape synth --hand human --object='-b c.obj'",
            ),
            (
                &[
                    "build",
                    "--only-stable",
                    "./-g.parquet",
                    "--threads",
                    "2",
                    "--resume",
                ],
                "landscape build ./-g.parquet --only-stable",
            ),
            (
                &["surface", "lj", "7", "--region=-1:1x21"],
                "landscape surface lj 7 --region=-1:1x21",
            ),
            (
                &["draw", "g.landscape", "--pick", "m1,m4"],
                "landscape draw g.landscape --pick m1,m4",
            ),
            // Folders are named only if they distinguish files or contain other named paths.
            (
                &[
                    "synth",
                    "--object",
                    "/a/one/x.toml",
                    "--config",
                    "/a/two/x.toml",
                ],
                "landscape synth --object one/x.toml --config two/x.toml",
            ),
            (
                &[
                    "synth",
                    "--object",
                    "ball",
                    "--hand",
                    "/p/arm/urdf/arm.urdf",
                    "--hand-folder",
                    "/p/arm/",
                ],
                "landscape synth --hand arm/urdf/arm.urdf --hand-folder arm --object ball",
            ),
            (
                &[
                    "surface",
                    "--command",
                    "python3 'my energy.py'",
                    "--region",
                    "0:1",
                ],
                r"landscape surface --command 'python3 '\''my energy.py'\''' --region 0:1",
            ),
        ] {
            assert_eq!(recorded(line), expected);
        }
    }

    #[test]
    fn words_are_quoted_for_the_shell() {
        for (word, expected) in [
            ("a.b-c_d/e=1:2,3", "a.b-c_d/e=1:2,3"),
            ("", "''"),
            ("a b", "'a b'"),
            ("it's", r"'it'\''s'"),
            ("$HOME*~;`x`", "'$HOME*~;`x`'"),
            ("Tasse ü", "'Tasse ü'"),
            ("a\nb'\u{1b}", r"$'a\012b\'\033'"),
        ] {
            assert_eq!(quoted(OsStr::new(word)), expected);
        }
    }

    #[cfg(unix)]
    #[test]
    fn names_that_are_no_text_are_quoted_too() {
        use std::os::unix::ffi::OsStrExt;
        assert_eq!(quoted(OsStr::from_bytes(b"a\xff1")), r"$'a\3771'");
    }
}
