//! The folder `X.landscape/`: manifest, minima, edges, paths, timings. Other modules write pictures, trees and the summary
//! into the same [`AtomicFolder`].
//!
//! | table | a row is | columns |
//! | --- | --- | --- |
//! | `minima.parquet` | a minimum | the fields of [`MinimumRow`]; its labels are the lists `labels` and `label_counts` |
//! | `edges.parquet` | a pair that was tried | the fields of [`EdgeRow`] |
//! | `paths.parquet` | an image of an edge's path | the fields of [`PathPoint`]; its terms are the columns `term_<name>` |
//!
//! The folder of a searched surface also has `stationary.parquet`, with one row per minimum or saddle
//! ([`StationaryRow`](super::StationaryRow)).
//!
//! A landscape that `landscape build` mapped also has `attempts.parquet`, the
//! searches and geodesics that were tried ([`write_attempts`](super::write_attempts)), and `grasps.parquet`, the grasps whose
//! ids are the members of minima ([`GraspFile`]).
//!
//! `landscape.json` lists under `checksums` the [`content_hash`](super::content_hash) of each table, and of itself without
//! that list. They are checked when a table is read. Texts and pictures are made from the tables and may be edited or drawn
//! again. If the manifest has no such list, nothing is checked.
//!
//! A field that is an `Option` may be null, because no path was found or the value was not computed.

use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::fs;
use std::path::Path;

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::atomic::AtomicFolder;
use super::columns::Columns;
use super::error::{Fault, StoreError};
use super::grasps::GraspFile;
use super::machine::Machine;
use super::metadata::{HandMetadata, ObjectMetadata, Source, bad, check_version, content_hash};
use super::overrides::Overrides;
use super::row::{self, Column, columns};
use super::table::{FLOAT, IDS, TEXTS, Table};

const MINIMA: &str = "minima.parquet";
const GRASPS: &str = "grasps.parquet";
const EDGES: &str = "edges.parquet";
const PATHS: &str = "paths.parquet";
const MANIFEST: &str = "landscape.json";
const TIMINGS: &str = "timings.json";
const CHECKSUMS: &str = "checksums";
const FORMAT: &str = "landscape";

/// A row of `minima.parquet`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MinimumRow {
    /// Number of the minimum. Minima are sorted by energy.
    pub id: u64,
    /// Its energy.
    pub energy: f64,
    /// Its coordinates.
    pub coordinates: Vec<f64>,
    /// Ids of the grasps that quench into it.
    pub members: Vec<u64>,
    /// Number of its family, the leaf of the collapsed tree.
    pub family: u64,
    /// Number of members for each label.
    pub labels: BTreeMap<String, u64>,
}

impl MinimumRow {
    /// The label that most members carry, the first in the alphabet at a tie.
    pub fn label(&self) -> Option<&str> {
        let most = self.labels.iter().rev().max_by_key(|(_, count)| **count);
        most.map(|(label, _)| label.as_str())
    }
}

/// A row of `edges.parquet`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct EdgeRow {
    /// One minimum.
    pub a: u64,
    /// The other.
    pub b: u64,
    /// Highest energy on the path; `None` if no path was found.
    pub height: Option<f64>,
    /// `height` − max(energy of a, energy of b).
    pub relative_barrier: Option<f64>,
    /// Length of the path in the metric of the space.
    pub length: Option<f64>,
    /// `saddle`, `given`, `path`, `chain` or `none`.
    pub evidence: String,
    /// The energy term that dominates at the highest point.
    pub term: Option<String>,
    /// Lowest raw attraction–diffusion barrier height from a to b.
    pub chain_forward: Option<f64>,
    /// Lowest raw attraction–diffusion barrier height from b to a.
    pub chain_backward: Option<f64>,
    /// Raw barrier heights of all chains from a to b that arrived.
    pub chains_forward: Vec<f64>,
    /// Raw barrier heights of all chains from b to a that arrived.
    pub chains_backward: Vec<f64>,
    /// Number of chains in both directions, including those that did not arrive.
    pub chain_runs: u64,
    /// Number of energy evaluations.
    pub evaluations: u64,
    /// What happens to the contacts on the path: `sliding`, `rolling`, `regrasping` or `letting go`. The column is absent if
    /// the energy does not tell what touches.
    pub way: Option<String>,
}

/// A row of `paths.parquet`: one point of the path of one edge.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PathPoint {
    /// The minimum where the path starts.
    pub a: u64,
    /// The minimum where it ends.
    pub b: u64,
    /// Number of the image, from 0 at a.
    pub image: u64,
    /// Its coordinates.
    pub coordinates: Vec<f64>,
    /// Its energy.
    pub energy: f64,
    /// Energy by term at the highest image; `None` elsewhere.
    pub terms: Option<Vec<f64>>,
}

/// `landscape.json`: the hand and object, the way the landscape was made, and the results.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Manifest {
    /// Version of the program that wrote it.
    pub program_version: String,
    /// The command line that makes it again.
    pub command: String,
    /// Seed of all random draws.
    pub seed: u64,
    /// The grasps it was made from.
    pub source: Source,
    /// The landscape to which these grasps were added, if any, and the hash of its manifest.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub onto: Option<Source>,
    /// The hand; `None` for a model surface.
    pub hand: Option<HandMetadata>,
    /// The object; `None` for a model surface.
    pub object: Option<ObjectMetadata>,
    /// Scale factor of the object.
    pub scale: f64,
    /// Terms, weights and constants of the energy.
    pub energy: Value,
    /// All other settings.
    pub settings: Value,
    /// Names of the energy terms, in the order of [`PathPoint::terms`].
    pub terms: Vec<String>,
    /// Largest relative barrier inside a family, in units of the energy.
    pub family_barrier: Option<f64>,
    /// Cost of letting go in units of the energy, the physical scale of barriers; `None` if the energy has no such scale.
    #[serde(default)]
    pub letting_go: Option<f64>,
    /// Sizes of the landscape.
    pub counts: Counts,
    /// Number of edges with each kind of evidence.
    pub evidence: BTreeMap<String, u64>,
    /// Named results that have no table: agreement with labels ….
    pub findings: BTreeMap<String, Value>,
    /// Warnings for the reader of the results.
    pub warnings: Vec<String>,
}

/// Sizes of a landscape.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Counts {
    /// Number of input grasps.
    pub grasps: u64,
    /// Number of distinct minima.
    pub minima: u64,
    /// Number of families of minima.
    pub families: u64,
    /// Number of pairs of minima that were tried.
    pub pairs: u64,
    /// Number of components without a path between them.
    pub components: u64,
    /// Number of energy evaluations.
    pub evaluations: u64,
}

/// `timings.json`: the only file in the folder that depends on the machine.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Timings {
    /// Number of threads.
    pub threads: usize,
    /// Phases in the order of execution.
    pub phases: Vec<Phase>,
    /// The build of the program, which may change the last bits of results, and the processor.
    #[serde(default)]
    pub machine: Machine,
}

/// A phase of a run.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Phase {
    /// Name of the phase.
    pub name: String,
    /// Wall-clock time, seconds.
    pub seconds: f64,
    /// Number of energy evaluations.
    pub evaluations: u64,
}

/// The tables and the manifest of a landscape.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LandscapeFiles {
    /// `landscape.json`.
    pub manifest: Manifest,
    /// `minima.parquet`.
    pub minima: Vec<MinimumRow>,
    /// `edges.parquet`.
    pub edges: Vec<EdgeRow>,
    /// `paths.parquet`.
    pub paths: Vec<PathPoint>,
}

impl LandscapeFiles {
    /// Writes all four files. Equal content gives equal bytes. The manifest lists the checksums of all tables that are then
    /// in the folder, so other tables must be written before.
    ///
    /// # Errors
    /// If a number is not finite, or the folder cannot be written or read.
    ///
    /// # Panics
    /// If a path image has another number of terms than the manifest.
    pub fn write(&self, folder: &AtomicFolder) -> Result<(), StoreError> {
        for (name, columns) in [
            (MINIMA, minima_columns(&self.minima)),
            (EDGES, edge_columns(&self.edges)),
            (PATHS, self.path_columns()),
        ] {
            let path = folder.path().join(name);
            folder.write(name, &columns.encode(&path, &table_head(name))?)?;
        }
        let manifest = serde_json::to_value(&self.manifest).expect("a manifest is plain data");
        let mut document = json!({ "format": FORMAT, "schema_version": super::SCHEMA_VERSION });
        if let (Value::Object(document), Value::Object(manifest)) = (&mut document, manifest) {
            document.extend(manifest);
        }
        let checksums = Checksums::of(folder.path(), &document)?;
        document[CHECKSUMS] = json!(checksums);
        folder.write(MANIFEST, &pretty(&document))
    }

    /// Reads a finished landscape.
    ///
    /// # Errors
    /// If the folder is not one, or if a file in it is missing, damaged, altered, or of another landscape or version.
    pub fn read(folder: &Path) -> Result<Self, StoreError> {
        let (manifest, _) = read_manifest(folder)?;
        Ok(Self {
            minima: read_minima(&read_table(folder, MINIMA)?)?,
            edges: read_edges(&read_table(folder, EDGES)?)?,
            paths: read_paths(&read_table(folder, PATHS)?, &manifest.terms)?,
            manifest,
        })
    }

    /// The manifest of a finished landscape alone, without its tables.
    ///
    /// # Errors
    /// If the folder is not one, or if the manifest is damaged, altered or of another version.
    pub fn manifest(folder: &Path) -> Result<Manifest, StoreError> {
        let (manifest, _) = read_manifest(folder)?;
        Ok(manifest)
    }

    /// The grasps of a finished landscape; `None` for a landscape of a surface.
    ///
    /// # Errors
    /// If the table is damaged, altered, or of another landscape or version.
    pub fn grasps(folder: &Path) -> Result<Option<GraspFile>, StoreError> {
        if !has_table(folder, GRASPS)? {
            return Ok(None);
        }
        // This compares the checksum.
        read_table(folder, GRASPS)?;
        let (file, _) = GraspFile::read(&folder.join(GRASPS), Overrides::default())?;
        Ok(Some(file))
    }

    /// Writes the grasps of a landscape into its folder, before [`LandscapeFiles::write`].
    ///
    /// # Errors
    /// If [`GraspFile::read`] would refuse them, or the folder cannot be written.
    pub fn write_grasps(grasps: &GraspFile, folder: &AtomicFolder) -> Result<(), StoreError> {
        let path = folder.path().join(GRASPS);
        folder.write(GRASPS, &grasps.encode(&path)?)
    }

    /// [`content_hash`] of the manifest in `folder`, which lists the hashes of all tables.
    ///
    /// # Errors
    /// If there is no manifest.
    pub fn content_hash(folder: &Path) -> Result<String, StoreError> {
        let path = folder.join(MANIFEST);
        let bytes = fs::read(&path).map_err(StoreError::io("read", &path))?;
        Ok(content_hash(&[&bytes]))
    }

    fn path_columns(&self) -> Columns {
        let mut columns = Columns::default();
        row::write(PATH, &self.paths, &mut columns);
        for (term, name) in self.manifest.terms.iter().enumerate() {
            let value = |row: &PathPoint| row.terms.as_ref().map(|terms| terms[term]);
            columns.optional_floats(&format!("term_{name}"), self.paths.iter().map(value));
        }
        columns
    }
}

impl Timings {
    /// Writes `timings.json`.
    ///
    /// # Errors
    /// If the folder cannot be written.
    pub fn write(&self, folder: &AtomicFolder) -> Result<(), StoreError> {
        folder.write(TIMINGS, &pretty(self))
    }
}

/// Metadata of a table of a landscape.
pub(super) fn table_head(name: &str) -> String {
    json!({ "format": FORMAT, "schema_version": super::SCHEMA_VERSION, "table": name }).to_string()
}

fn pretty(value: &impl Serialize) -> Vec<u8> {
    let value = serde_json::to_value(value).expect("plain data with text keys is always JSON");
    format!("{value:#}\n").into_bytes()
}

const MINIMUM: &[Column<MinimumRow>] =
    columns![id, energy, coordinates if present, members, family];

const EDGE: &[Column<EdgeRow>] = columns![
    a,
    b,
    height,
    relative_barrier,
    length,
    evidence,
    term,
    chain_forward,
    chain_backward,
    chains_forward if present,
    chains_backward if present,
    chain_runs if present,
    evaluations,
];

const WAYS: &[Column<EdgeRow>] = columns![way if present];

const PATH: &[Column<PathPoint>] = columns![a, b, image, coordinates if present, energy];

fn minima_columns(minima: &[MinimumRow]) -> Columns {
    let mut columns = Columns::default();
    row::write(MINIMUM, minima, &mut columns);
    let labels = minima.iter().map(|row| row.labels.keys());
    columns.text_lists(
        "labels",
        labels.map(|names| names.map(String::as_str).collect()),
    );
    let counts = minima.iter().map(|row| row.labels.values().copied());
    let counts: Vec<Vec<u64>> = counts.map(Iterator::collect).collect();
    columns.ids("label_counts", counts.iter().map(Vec::as_slice));
    columns
}

fn edge_columns(edges: &[EdgeRow]) -> Columns {
    let mut columns = Columns::default();
    row::write(EDGE, edges, &mut columns);
    if edges.iter().any(|edge| edge.way.is_some()) {
        row::write(WAYS, edges, &mut columns);
    }
    columns
}

/// [`content_hash`] of each table by its file name, and of the manifest without this list.
#[derive(Debug, Serialize, Deserialize)]
struct Checksums(BTreeMap<String, String>);

impl Checksums {
    /// Checksums of the tables in `folder` and of its manifest, which does not list them yet.
    fn of(folder: &Path, manifest: &Value) -> Result<Self, StoreError> {
        let mut checksums =
            BTreeMap::from([(MANIFEST.to_owned(), content_hash(&[&pretty(manifest)]))]);
        let unread = || StoreError::io("read", folder);
        for entry in fs::read_dir(folder).map_err(unread())? {
            let path = entry.map_err(unread())?.path();
            if path.extension().is_some_and(|kind| kind == "parquet")
                && let Some(name) = path.file_name().and_then(OsStr::to_str)
            {
                let bytes = fs::read(&path).map_err(StoreError::io("read", &path))?;
                checksums.insert(name.to_owned(), content_hash(&[&bytes]));
            }
        }
        Ok(Self(checksums))
    }

    fn check(&self, folder: &Path, name: &str, bytes: &[u8]) -> Result<(), StoreError> {
        if self.0.get(name) == Some(&content_hash(&[bytes])) {
            return Ok(());
        }
        Err(StoreError::NotOfLandscape {
            path: folder.join(name),
            manifest: folder.join(MANIFEST),
        })
    }
}

/// The manifest of a finished landscape and its checksums.
fn read_manifest(folder: &Path) -> Result<(Manifest, Checksums), StoreError> {
    let path = folder.join(MANIFEST);
    let unfinished = || StoreError::Unfinished(folder.to_path_buf());
    let bytes = fs::read(&path).map_err(|source| match source.kind() {
        std::io::ErrorKind::NotFound if folder.is_dir() => unfinished(),
        _ if folder.is_file() => StoreError::NoFolder(folder.to_path_buf()),
        _ => StoreError::io("read", &path)(source),
    })?;
    let mut document: Value =
        serde_json::from_slice(&bytes).map_err(|error| bad(&path, error.to_string()))?;
    if document["format"] != FORMAT {
        return Err(unfinished());
    }
    check_version(&path, &document)?;
    let unusable = |error: serde_json::Error| bad(&path, error.to_string());
    let listed = (document.as_object_mut()).and_then(|document| document.remove(CHECKSUMS));
    let Some(listed) = listed else {
        return Err(StoreError::Altered(path));
    };
    let checksums: Checksums = serde_json::from_value(listed).map_err(unusable)?;
    if checksums.0.get(MANIFEST) != Some(&content_hash(&[&pretty(&document)])) {
        return Err(StoreError::Altered(path));
    }
    let manifest = serde_json::from_value(document).map_err(unusable)?;
    Ok((manifest, checksums))
}

/// Whether the landscape in `folder` has this table or lists it.
pub(super) fn has_table(folder: &Path, name: &str) -> Result<bool, StoreError> {
    let (_, checksums) = read_manifest(folder)?;
    Ok(checksums.0.contains_key(name) || folder.join(name).exists())
}

/// Opens a table of this version that belongs to the landscape in `folder`.
pub(super) fn read_table(folder: &Path, name: &str) -> Result<Table, StoreError> {
    let path = folder.join(name);
    let (_, checksums) = read_manifest(folder)?;
    let bytes = fs::read(&path).map_err(StoreError::io("read", &path))?;
    checksums.check(folder, name, &bytes)?;
    let table = Table::of_bytes(&path, bytes)?;
    let head = table.metadata.as_deref().unwrap_or_default();
    check_version(&path, &serde_json::from_str(head).unwrap_or_default())?;
    Ok(table)
}

fn read_minima(table: &Table) -> Result<Vec<MinimumRow>, StoreError> {
    let mut rows = vec![MinimumRow::default(); table.rows];
    row::read(MINIMUM, table, &mut rows)?;
    let labels = table.required("labels", &TEXTS)?;
    let counts = table.required("label_counts", &IDS)?;
    for (number, (labels, counts)) in labels.into_iter().zip(counts).enumerate() {
        if labels.len() != counts.len() {
            let (found, expected) = (counts.len(), labels.len());
            let fault = Fault::Length {
                column: "label_counts".to_owned(),
                found,
                expected,
            };
            return Err(table.fault(number, fault));
        }
        rows[number].labels = labels.into_iter().zip(counts).collect();
    }
    Ok(rows)
}

fn read_edges(table: &Table) -> Result<Vec<EdgeRow>, StoreError> {
    let mut rows = vec![EdgeRow::default(); table.rows];
    row::read(EDGE, table, &mut rows)?;
    row::read(WAYS, table, &mut rows)?;
    Ok(rows)
}

fn read_paths(table: &Table, terms: &[String]) -> Result<Vec<PathPoint>, StoreError> {
    let mut rows = vec![PathPoint::default(); table.rows];
    row::read(PATH, table, &mut rows)?;
    let columns = terms
        .iter()
        .map(|name| table.optional(&format!("term_{name}"), &FLOAT));
    let columns = columns.collect::<Result<Vec<_>, _>>()?;
    for (number, row) in rows.iter_mut().enumerate() {
        let terms = columns.iter().map(|column| column[number]);
        row.terms = (terms.collect::<Option<Vec<_>>>()).filter(|terms| !terms.is_empty());
    }
    Ok(rows)
}
