//! Checks of outputs: an output must not be an input, nor replace a file that this program did not make.

use std::fs::{self, File};
use std::io::{Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use anyhow::{Context, ensure};
use serde_json::Value;

use super::args::Common;
use crate::cli::printing::{shown, tell_text};
use crate::evaluation::taxonomy::Taught;
use crate::figure::MAKER;
use crate::figure::chart::Chart;
use crate::store::{FileSet, GraspFile, content_hash};

/// Number of bytes at each end of a file that are searched for its maker.
const LOOKED_AT: u64 = 4096;

/// Rejects an output file before any work if it cannot be written, if it is one of the `inputs`, or (without `--force`) if
/// it exists and was not made by this program.
pub(super) fn check_file(output: &Path, inputs: &[&Path], force: bool) -> anyhow::Result<()> {
    check_place(output)?;
    ensure!(
        !output.is_dir(),
        "--output {}: this is a folder, but the name of a file is needed",
        output.display()
    );
    if force {
        return Ok(());
    }
    check_inputs(output, inputs)?;
    ensure!(
        !output.exists() || made_here(output),
        "{} exists and was not made by landscape as a file of this kind: name another file, or overwrite it (--force)",
        output.display()
    );
    Ok(())
}

/// A name with an ending after it.
pub(super) fn with_ending(output: &Path, ending: &str) -> PathBuf {
    let mut name = output.as_os_str().to_owned();
    name.push(format!(".{ending}"));
    name.into()
}

/// The given output, or the name of the input, in its folder, with another ending.
pub(super) fn given_or_beside(
    output: Option<&PathBuf>,
    input: &Path,
    ending: &str,
) -> anyhow::Result<PathBuf> {
    if let Some(output) = output {
        return Ok(output.clone());
    }
    ensure!(
        input.file_name().is_some(),
        "{}: name the output with --output",
        input.display()
    );
    Ok(input.with_extension(ending))
}

/// Rejects the files of [`write_report`] as [`check_file`] does; `tables` are the endings of its tables.
pub(super) fn check_report(
    output: &Path,
    tables: &[&str],
    inputs: &[&Path],
    force: bool,
) -> anyhow::Result<()> {
    let endings = ["svg", "png", "json", "md"].iter().chain(tables);
    let mut files = endings.map(|ending| with_ending(output, ending));
    files.try_for_each(|file| check_file(&file, inputs, force))
}

/// What a command found, as the files of a report hold it.
pub(super) struct Report {
    /// Markdown.
    pub(super) text: String,
    pub(super) value: Value,
    pub(super) chart: Option<Chart>,
    /// Endings and texts of further files.
    pub(super) tables: Vec<(&'static str, String)>,
}

/// Prints a report, and writes it as text (.md) and JSON, with its chart (.svg, .png) and its tables, if there is an output.
pub(super) fn write_report(
    output: Option<&Path>,
    report: Report,
    common: &Common,
) -> anyhow::Result<()> {
    let text = shown(&report.text);
    if let Some(output) = output {
        let mut files = FileSet::default();
        for (ending, table) in &report.tables {
            files.add(&with_ending(output, ending), table.as_bytes())?;
        }
        if let Some(chart) = report.chart {
            let sheet = chart.draw()?;
            for path in ["svg", "png"].map(|ending| with_ending(output, ending)) {
                files.add(&path, &sheet.encode(&path)?)?;
            }
        }
        let json = format!("{:#}\n", report.value);
        files.add(&with_ending(output, "json"), json.as_bytes())?;
        let signed = format!("{text}\n<!-- Made by {MAKER}. -->\n");
        files.add(&with_ending(output, "md"), signed.as_bytes())?;
        files.finish()?;
    }
    let written = output.map(|output| with_ending(output, "md").display().to_string());
    tell_text(common, (&text, &report.value), written.as_deref())
}

/// Rejects a picture as [`check_file`] does, and (without `--force`) if it shows something else than `source`, which is what
/// [`source_of`] returned for it.
pub(super) fn check_picture(
    picture: &Path,
    input: &str,
    source: &str,
    force: bool,
) -> anyhow::Result<()> {
    check_file(picture, &[Path::new(input)], force)?;
    let png = |path: &Path| {
        path.extension()
            .is_some_and(|ending| ending.eq_ignore_ascii_case("png"))
    };
    if force || !png(picture) || !picture.exists() {
        return Ok(());
    }
    let mark = format!("Source\0{source}");
    let [head, _] = ends(picture)?;
    ensure!(
        head.windows(mark.len())
            .any(|window| window == mark.as_bytes()),
        "{} shows something else than {input}: name another picture (-o), or overwrite it (--force)",
        picture.display()
    );
    Ok(())
}

/// What a picture was made of: a name that the program knows, or a hash of where the file is, seen from the picture if it is
/// in the same folder or below, so that a folder can be moved.
pub(super) fn source_of(input: &str, names: &[&str], picture: &Path) -> String {
    if names.contains(&input) {
        return input.to_owned();
    }
    let whole = |path: &Path| path.canonicalize().unwrap_or_else(|_| path.to_owned());
    let folder = picture.parent().filter(|folder| *folder != Path::new(""));
    let (file, folder) = (
        whole(Path::new(input)),
        whole(folder.unwrap_or(Path::new("."))),
    );
    let place = file.strip_prefix(&folder).unwrap_or(&file);
    content_hash(&[place.to_string_lossy().as_bytes()])
}

/// Rejects a side file before any work if it cannot be written, or (without `--force`) if it exists, because users edit
/// such files.
pub(super) fn check_side_file(side_file: &Path, force: bool) -> anyhow::Result<()> {
    check_place(side_file)?;
    ensure!(
        !side_file.exists() || force,
        "{} exists and may have been edited: name another file (--side-file), or overwrite it (--force)",
        side_file.display()
    );
    Ok(())
}

/// Rejects an output folder before any work if it cannot be written, if it is one of the `inputs`, or (without `--force`)
/// if it contains files other than the `expected` ones.
pub(super) fn check_folder(
    output: &Path,
    inputs: &[&Path],
    expected: impl Fn(&str) -> bool,
    common: &Common,
) -> anyhow::Result<()> {
    check_place(output)?;
    ensure!(
        output.is_dir() || !output.exists(),
        "--output {}: this is a file, but the name of a folder is needed",
        output.display()
    );
    check_inputs(output, inputs)?;
    if common.force || !output.exists() {
        return Ok(());
    }
    let entries = fs::read_dir(output)
        .with_context(|| format!("--output: cannot read {}", output.display()))?;
    for entry in entries {
        let name = entry?.file_name();
        let name = name.to_string_lossy();
        ensure!(
            expected(&name) || name.ends_with(".partial"),
            "--output {}: this folder contains {name}, which this command would not write: name another folder, or add to its \
             files (--force)",
            output.display()
        );
    }
    Ok(())
}

/// Creates an output folder that passed [`check_folder`], with the folders around it.
pub(super) fn make_folder(output: &Path) -> anyhow::Result<MadeFolder> {
    let missing = output
        .ancestors()
        .take_while(|folder| *folder != Path::new("") && !folder.exists());
    let made = MadeFolder(missing.map(Path::to_path_buf).collect());
    fs::create_dir_all(output)
        .with_context(|| format!("cannot create the folder {}", output.display()))?;
    Ok(made)
}

/// Folders that this run has made, innermost first. Those that are empty at the end, as after an error, are removed.
#[must_use = "folders that are still empty are removed when this is dropped"]
pub(super) struct MadeFolder(Vec<PathBuf>);

impl MadeFolder {
    /// Leaves the folders even if they are empty, because other processes may be about to write there.
    pub(super) fn keep(mut self) {
        self.0.clear();
    }
}

impl Drop for MadeFolder {
    fn drop(&mut self) {
        // A folder that is not empty cannot be removed in this way, and neither can those around it.
        for folder in &self.0 {
            if fs::remove_dir(folder).is_err() {
                return;
            }
        }
    }
}

/// Rejects an output whose parent folder is missing.
pub(super) fn check_place(output: &Path) -> anyhow::Result<()> {
    if let Some(folder) = output.parent().filter(|folder| *folder != Path::new("")) {
        ensure!(
            folder.is_dir(),
            "--output {}: the folder {} does not exist",
            output.display(),
            folder.display()
        );
    }
    Ok(())
}

/// Rejects an output that is one of the inputs, by any path.
pub(super) fn check_inputs(output: &Path, inputs: &[&Path]) -> anyhow::Result<()> {
    let Ok(place) = output.canonicalize() else {
        // A missing file cannot be an input.
        return Ok(());
    };
    for input in inputs {
        ensure!(
            input.canonicalize().ok().as_ref() != Some(&place),
            "{} is an input of this command: name another output (a file is overwritten with --force)",
            output.display()
        );
    }
    Ok(())
}

/// Whether this program made a file, as far as its kind (by name) shows.
fn made_here(path: &Path) -> bool {
    let ending = path.extension().unwrap_or_default().to_string_lossy();
    let ending = ending.to_lowercase();
    if ending == "parquet" {
        return GraspFile::is_ours(path);
    }
    let Ok([head, tail]) = ends(path) else {
        return false;
    };
    let holds = |bytes: &[u8], mark: &str| {
        let mark = mark.as_bytes();
        bytes.windows(mark.len()).any(|window| window == mark)
    };
    let made_by = format!("Made by {MAKER}");
    match ending.as_str() {
        "png" => holds(&head, &format!("Software\0{MAKER}")),
        // The generator comes after the data of the animation.
        "glb" => {
            fs::read(path).is_ok_and(|bytes| holds(&bytes, &format!("\"generator\":\"{MAKER} ")))
        }
        "csv" => [&b"id,"[..], b"set,kind,", b"set,id,"]
            .iter()
            .any(|start| head.starts_with(start)),
        "npy" => head.starts_with(b"\x93NUMPY"),
        "json" => fs::read(path).is_ok_and(|bytes| made_json(&bytes)),
        "labeller" => fs::read_to_string(path).is_ok_and(|text| Taught::parse(&text).is_ok()),
        _ => holds(&head, &made_by) || holds(&tail, &made_by),
    }
}

/// Whether this is a table of grasps, or an object with this program's name.
fn made_json(bytes: &[u8]) -> bool {
    match serde_json::from_slice::<Value>(bytes) {
        Ok(Value::Array(rows)) => rows.iter().all(|row| row.get("translation_m").is_some()),
        Ok(value) => value["made_by"] == MAKER,
        Err(_) => false,
    }
}

/// Whether this is the name of a 3D scene.
pub(super) fn is_scene(path: &Path) -> bool {
    let ending = path.extension();
    ending.is_some_and(|ending| ending.eq_ignore_ascii_case("glb"))
}

fn ends(path: &Path) -> std::io::Result<[Vec<u8>; 2]> {
    let mut file = File::open(path)?;
    let length = file.metadata()?.len();
    let (mut head, mut tail) = (Vec::new(), Vec::new());
    (&file).take(LOOKED_AT).read_to_end(&mut head)?;
    file.seek(SeekFrom::Start(length.saturating_sub(LOOKED_AT)))?;
    file.take(LOOKED_AT).read_to_end(&mut tail)?;
    Ok([head, tail])
}
