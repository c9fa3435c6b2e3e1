//! The folder `X.landscape/`: manifest, minima, edges, paths, timings. Pictures, trees and the summary are written by
//! others into the same [`AtomicFolder`].
//!
//! | table | a row is | columns |
//! | --- | --- | --- |
//! | `minima.parquet` | a minimum | `id`, `energy`, `coordinates`, `choice` (contact set), `members` (grasp ids), `group`, `labels` and `label_counts` (lists of equal length) |
//! | `edges.parquet` | a pair that was tried | `a`, `b` (ids), `height`∅, `relative_barrier`∅, `length`∅, `evidence`, `term`∅, `chain_forward`∅, `chain_backward`∅ (lowest raw barriers), `chains_forward`, `chains_backward` (all of them: the spread over replicas and directions), `chain_runs`, `evaluations` |
//! | `paths.parquet` | an image of an edge's path | `a`, `b`, `image`, `coordinates`, `energy`, `choice`, `term_<name>`∅ (at the highest image only) |
//!
//! The folder of a searched surface also holds `stationary.parquet`, a row a minimum or saddle
//! ([`StationaryRow`](super::StationaryRow)): `index`, `id`, `a`, `b`, `energy`, `coordinates`, `gradient_norm`, `curvatures`,
//! `searches`, `verdict` (`sound`, or `degenerate` where it is not isolated).
//!
//! A landscape whose merges have a support holds `resampled.parquet` as well: the merges of the resampled trees
//! ([`write_resampled`](super::write_resampled)).
//!
//! `landscape.json` lists under `checksums` the [`content_hash`](super::content_hash) of each table, and of itself without
//! that list; whoever reads a table checks it. Texts and pictures are made from the tables and may be
//! edited or drawn again. A folder whose manifest has no such list is read as it is.
//!
//! `∅` may be null: no path was found, or the value was not computed.

use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::fs;
use std::path::Path;

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::atomic::AtomicFolder;
use super::columns::Columns;
use super::error::{Fault, StoreError, Warning};
use super::metadata::{HandMetadata, ObjectMetadata, bad, check_version, content_hash};
use super::table::{FLOAT, IDS, INDICES, TEXT, TEXTS, Table, VECTOR, WHOLE};

const MINIMA: &str = "minima.parquet";
const EDGES: &str = "edges.parquet";
const PATHS: &str = "paths.parquet";
const MANIFEST: &str = "landscape.json";
const TIMINGS: &str = "timings.json";
const CHECKSUMS: &str = "checksums";
const FORMAT: &str = "landscape";

/// A row of `minima.parquet`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MinimumRow {
    /// Number of the minimum; minima are sorted by energy.
    pub id: u64,
    /// Its energy.
    pub energy: f64,
    /// Where it is.
    pub coordinates: Vec<f64>,
    /// Contact set realised there.
    pub choice: Vec<u32>,
    /// Ids of the grasps that quenched into it.
    pub members: Vec<u64>,
    /// Number of its group, the leaf of the collapsed tree.
    pub group: u64,
    /// How many members carry which label.
    pub labels: BTreeMap<String, u64>,
}

/// A row of `edges.parquet`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct EdgeRow {
    /// One minimum.
    pub a: u64,
    /// The other.
    pub b: u64,
    /// Highest energy on the way; `None` where no path was found.
    pub height: Option<f64>,
    /// `height` − max(energy of a, energy of b).
    pub relative_barrier: Option<f64>,
    /// Length of the path in the metric of the space.
    pub length: Option<f64>,
    /// `saddle`, `seam`, `path`, `chain` or `none`.
    pub evidence: String,
    /// The energy term that dominates the top.
    pub term: Option<String>,
    /// Lowest raw attraction–diffusion barrier height from a to b.
    pub chain_forward: Option<f64>,
    /// Lowest raw attraction–diffusion barrier height from b to a.
    pub chain_backward: Option<f64>,
    /// Raw barrier heights of all chains from a to b that arrived.
    pub chains_forward: Vec<f64>,
    /// Raw barrier heights of all chains from b to a that arrived.
    pub chains_backward: Vec<f64>,
    /// Chains run in both directions, whether they arrived or not.
    pub chain_runs: u64,
    /// Energy evaluations spent.
    pub evaluations: u64,
}

/// A row of `paths.parquet`: one image of the path of one edge.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PathRow {
    /// The minimum where the path starts.
    pub a: u64,
    /// The minimum where it ends.
    pub b: u64,
    /// Number of the image, from 0 at a.
    pub image: u64,
    /// Where it is.
    pub coordinates: Vec<f64>,
    /// Its energy.
    pub energy: f64,
    /// Contact set realised there.
    pub choice: Vec<u32>,
    /// Energy by term, at the highest image; elsewhere `None`.
    pub terms: Option<Vec<f64>>,
}

/// `landscape.json`: what the landscape is of, how it was made, what was found.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Manifest {
    /// Version of the program that wrote it.
    pub program_version: String,
    /// The command line that remakes it.
    pub command: String,
    /// Seed of every random draw.
    pub seed: u64,
    /// The grasps it was made from.
    pub source: Source,
    /// The hand; `None` for a model surface.
    pub hand: Option<HandMetadata>,
    /// The object; `None` for a model surface.
    pub object: Option<ObjectMetadata>,
    /// Factor on the object's size.
    pub scale: f64,
    /// Terms, weights and constants of the energy.
    pub energy: Value,
    /// Everything else that was set.
    pub settings: Value,
    /// Names of the energy terms, in the order of [`PathRow::terms`].
    pub terms: Vec<String>,
    /// Relative barrier up to which minima form one group.
    pub group_barrier: Option<f64>,
    /// How much there is of everything.
    pub counts: Counts,
    /// How many edges rest on which evidence.
    pub evidence: BTreeMap<String, u64>,
    /// Named results that have no table: hover cost, agreement with labels …
    pub findings: BTreeMap<String, Value>,
    /// What a reader should know before trusting it.
    pub warnings: Vec<String>,
}

/// The input of a landscape.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Source {
    /// File name, without folder.
    pub name: String,
    /// [`content_hash`](super::content_hash) of its bytes.
    pub content_hash: String,
}

/// How much of everything a landscape holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Counts {
    /// Grasps that went in.
    pub grasps: u64,
    /// Distinct minima they quenched into.
    pub minima: u64,
    /// Groups of minima.
    pub groups: u64,
    /// Pairs of minima that were tried.
    pub pairs: u64,
    /// Components that no path joins.
    pub components: u64,
    /// Energy evaluations.
    pub evaluations: u64,
}

/// `timings.json`: what depends on the machine, and on nothing else in the folder.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Timings {
    /// Threads used.
    pub threads: usize,
    /// Phases in the order they ran.
    pub phases: Vec<Phase>,
}

/// A phase of a run.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Phase {
    /// What was done.
    pub name: String,
    /// Wall-clock time, seconds.
    pub seconds: f64,
    /// Energy evaluations.
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
    pub paths: Vec<PathRow>,
}

impl LandscapeFiles {
    /// Writes all four files; the same bytes for the same content. The manifest lists the checksums of all tables that
    /// the folder has then, so other tables are written before.
    ///
    /// # Errors
    /// If a number is not finite, or the folder cannot be written or read.
    ///
    /// # Panics
    /// If a path image has another number of terms than the manifest names.
    pub fn write(&self, folder: &AtomicFolder) -> Result<(), StoreError> {
        for (name, columns) in [
            (MINIMA, minima_columns(&self.minima)),
            (EDGES, edge_columns(&self.edges)),
            (PATHS, self.path_columns()),
        ] {
            let path = folder.path().join(name);
            folder.write(name, &columns.encode(&path, table_head(name))?)?;
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
    /// If the folder is not one, or a file of it is missing, damaged, altered, of another landscape or of another version.
    pub fn read(folder: &Path) -> Result<Self, StoreError> {
        let (manifest, _) = read_manifest(folder)?;
        Ok(Self {
            minima: read_minima(&read_table(folder, MINIMA)?)?,
            edges: read_edges(&read_table(folder, EDGES)?)?,
            paths: read_paths(&read_table(folder, PATHS)?, &manifest.terms)?,
            manifest,
        })
    }

    /// What is worth a warning about a landscape that can be read.
    ///
    /// # Errors
    /// If the folder is no landscape.
    pub fn warning(folder: &Path) -> Result<Option<Warning>, StoreError> {
        let (_, checksums) = read_manifest(folder)?;
        Ok(checksums.is_none().then(|| Warning::NoChecksums {
            path: folder.join(MANIFEST),
        }))
    }

    fn path_columns(&self) -> Columns {
        let rows = || self.paths.iter();
        let mut columns = Columns::default();
        columns.wholes("a", rows().map(|row| row.a));
        columns.wholes("b", rows().map(|row| row.b));
        columns.wholes("image", rows().map(|row| row.image));
        columns.vectors("coordinates", rows().map(|row| row.coordinates.as_slice()));
        columns.floats("energy", rows().map(|row| row.energy));
        columns.indices("choice", rows().map(|row| row.choice.as_slice()));
        for (term, name) in self.manifest.terms.iter().enumerate() {
            let value = |row: &PathRow| row.terms.as_ref().map(|terms| terms[term]);
            columns.optional_floats(&format!("term_{name}"), rows().map(value));
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

fn minima_columns(minima: &[MinimumRow]) -> Columns {
    let rows = || minima.iter();
    let counts: Vec<Vec<u64>> = rows()
        .map(|row| row.labels.values().copied().collect())
        .collect();
    let mut columns = Columns::default();
    columns.wholes("id", rows().map(|row| row.id));
    columns.floats("energy", rows().map(|row| row.energy));
    columns.vectors("coordinates", rows().map(|row| row.coordinates.as_slice()));
    columns.indices("choice", rows().map(|row| row.choice.as_slice()));
    columns.ids("members", rows().map(|row| row.members.as_slice()));
    columns.wholes("group", rows().map(|row| row.group));
    columns.text_lists(
        "labels",
        rows().map(|row| row.labels.keys().map(String::as_str).collect()),
    );
    columns.ids("label_counts", counts.iter().map(Vec::as_slice));
    columns
}

fn edge_columns(edges: &[EdgeRow]) -> Columns {
    let rows = || edges.iter();
    let mut columns = Columns::default();
    columns.wholes("a", rows().map(|row| row.a));
    columns.wholes("b", rows().map(|row| row.b));
    columns.optional_floats("height", rows().map(|row| row.height));
    columns.optional_floats("relative_barrier", rows().map(|row| row.relative_barrier));
    columns.optional_floats("length", rows().map(|row| row.length));
    columns.texts("evidence", rows().map(|row| row.evidence.as_str()));
    columns.optional_texts("term", rows().map(|row| row.term.as_deref()));
    columns.optional_floats("chain_forward", rows().map(|row| row.chain_forward));
    columns.optional_floats("chain_backward", rows().map(|row| row.chain_backward));
    columns.vectors(
        "chains_forward",
        rows().map(|row| row.chains_forward.as_slice()),
    );
    columns.vectors(
        "chains_backward",
        rows().map(|row| row.chains_backward.as_slice()),
    );
    columns.wholes("chain_runs", rows().map(|row| row.chain_runs));
    columns.wholes("evaluations", rows().map(|row| row.evaluations));
    columns
}

/// [`content_hash`] of each table by its file name, and of the manifest without this list.
#[derive(Debug, Serialize, Deserialize)]
struct Checksums(BTreeMap<String, String>);

impl Checksums {
    /// Of the tables in `folder` and its manifest, which does not yet list them.
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

/// The manifest of a finished landscape and its checksums, which older ones do not have.
fn read_manifest(folder: &Path) -> Result<(Manifest, Option<Checksums>), StoreError> {
    let path = folder.join(MANIFEST);
    let unfinished = || StoreError::Unfinished {
        path: folder.to_path_buf(),
    };
    let bytes = fs::read(&path).map_err(|source| match source.kind() {
        std::io::ErrorKind::NotFound if folder.is_dir() => unfinished(),
        _ if folder.is_file() => StoreError::NoFolder {
            path: folder.to_path_buf(),
        },
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
    let checksums: Option<Checksums> = listed
        .map(serde_json::from_value)
        .transpose()
        .map_err(unusable)?;
    if let Some(checksums) = &checksums
        && checksums.0.get(MANIFEST) != Some(&content_hash(&[&pretty(&document)]))
    {
        return Err(StoreError::Altered { path });
    }
    let manifest = serde_json::from_value(document).map_err(unusable)?;
    Ok((manifest, checksums))
}

/// Whether the landscape in `folder` has this table, or says that it has.
pub(super) fn has_table(folder: &Path, name: &str) -> Result<bool, StoreError> {
    let (_, checksums) = read_manifest(folder)?;
    Ok(
        checksums.is_some_and(|checksums| checksums.0.contains_key(name))
            || folder.join(name).exists(),
    )
}

/// Opens a table of this version that belongs to the landscape in `folder`.
pub(super) fn read_table(folder: &Path, name: &str) -> Result<Table, StoreError> {
    let path = folder.join(name);
    let (_, checksums) = read_manifest(folder)?;
    let bytes = fs::read(&path).map_err(StoreError::io("read", &path))?;
    if let Some(checksums) = checksums {
        checksums.check(folder, name, &bytes)?;
    }
    let table = Table::of_bytes(&path, bytes)?;
    let head = table.metadata.as_deref().unwrap_or_default();
    check_version(&path, &serde_json::from_str(head).unwrap_or_default())?;
    Ok(table)
}

fn read_minima(table: &Table) -> Result<Vec<MinimumRow>, StoreError> {
    let mut id = table.required("id", &WHOLE)?.into_iter();
    let mut energy = table.required("energy", &FLOAT)?.into_iter();
    let mut coordinates = table.required_unless_empty("coordinates")?.into_iter();
    let mut choice = table.required("choice", &INDICES)?.into_iter();
    let mut members = table.required("members", &IDS)?.into_iter();
    let mut group = table.required("group", &WHOLE)?.into_iter();
    let labels = table.required("labels", &TEXTS)?;
    let counts = table.required("label_counts", &IDS)?;
    let mut pairs = Vec::new();
    for (row, (labels, counts)) in labels.into_iter().zip(counts).enumerate() {
        if labels.len() != counts.len() {
            let (found, expected) = (counts.len(), labels.len());
            let fault = Fault::Length {
                column: "label_counts".to_owned(),
                found,
                expected,
            };
            return Err(table.fault(row, fault));
        }
        pairs.push(labels.into_iter().zip(counts).collect());
    }
    let minimum = |labels| {
        Some(MinimumRow {
            id: id.next()?,
            energy: energy.next()?,
            coordinates: coordinates.next()?,
            choice: choice.next()?,
            members: members.next()?,
            group: group.next()?,
            labels,
        })
    };
    Ok(pairs.into_iter().map_while(minimum).collect())
}

fn read_edges(table: &Table) -> Result<Vec<EdgeRow>, StoreError> {
    let mut a = table.required("a", &WHOLE)?.into_iter();
    let mut b = table.required("b", &WHOLE)?.into_iter();
    let mut height = table.optional("height", &FLOAT)?.into_iter();
    let mut relative_barrier = table.optional("relative_barrier", &FLOAT)?.into_iter();
    let mut length = table.optional("length", &FLOAT)?.into_iter();
    let mut evidence = table.required("evidence", &TEXT)?.into_iter();
    let mut term = table.optional("term", &TEXT)?.into_iter();
    let mut chain_forward = table.optional("chain_forward", &FLOAT)?.into_iter();
    let mut chain_backward = table.optional("chain_backward", &FLOAT)?.into_iter();
    let mut chains_forward = table.optional("chains_forward", &VECTOR)?.into_iter();
    let mut chains_backward = table.optional("chains_backward", &VECTOR)?.into_iter();
    let mut chain_runs = table.optional("chain_runs", &WHOLE)?.into_iter();
    let mut evaluations = table.required("evaluations", &WHOLE)?.into_iter();
    let edge = || {
        Some(EdgeRow {
            a: a.next()?,
            b: b.next()?,
            height: height.next()?,
            relative_barrier: relative_barrier.next()?,
            length: length.next()?,
            evidence: evidence.next()?,
            term: term.next()?,
            chain_forward: chain_forward.next()?,
            chain_backward: chain_backward.next()?,
            chains_forward: chains_forward.next()?.unwrap_or_default(),
            chains_backward: chains_backward.next()?.unwrap_or_default(),
            chain_runs: chain_runs.next()?.unwrap_or_default(),
            evaluations: evaluations.next()?,
        })
    };
    Ok(std::iter::from_fn(edge).collect())
}

fn read_paths(table: &Table, terms: &[String]) -> Result<Vec<PathRow>, StoreError> {
    let mut a = table.required("a", &WHOLE)?.into_iter();
    let mut b = table.required("b", &WHOLE)?.into_iter();
    let mut image = table.required("image", &WHOLE)?.into_iter();
    let mut coordinates = table.required_unless_empty("coordinates")?.into_iter();
    let mut energy = table.required("energy", &FLOAT)?.into_iter();
    let mut choice = table.required("choice", &INDICES)?.into_iter();
    let columns = terms
        .iter()
        .map(|name| table.optional(&format!("term_{name}"), &FLOAT));
    let columns = columns.collect::<Result<Vec<_>, _>>()?;
    let image_row = |row: usize| {
        Some(PathRow {
            a: a.next()?,
            b: b.next()?,
            image: image.next()?,
            coordinates: coordinates.next()?,
            energy: energy.next()?,
            choice: choice.next()?,
            terms: columns
                .iter()
                .map(|column| column[row])
                .collect::<Option<Vec<_>>>()
                .filter(|row| !row.is_empty()),
        })
    };
    Ok((0..table.rows).map_while(image_row).collect())
}

impl Table {
    /// Coordinates; where no row has any (imported minima), or there are no rows, there is no column for them.
    fn required_unless_empty(&self, name: &str) -> Result<Vec<Vec<f64>>, StoreError> {
        if self.rows == 0 || !self.has(name) {
            Ok(vec![Vec::new(); self.rows])
        } else {
            self.required(name, &VECTOR)
        }
    }
}
