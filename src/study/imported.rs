//! Landscapes of other programs: a landscape folder from `min.data` and `ts.data`.

use std::collections::BTreeMap;

use petgraph::visit::EdgeRef;
use serde_json::json;

use super::Digits;
use super::drawing::{Drawing, Titles, not_drawn};
use super::error::StudyError;
use super::report::WrittenLandscape;
use super::tables::write_database;
use crate::figure::leaves_of;
use crate::printable::{counted, printable};
use crate::store::{AtomicFolder, Counts, EdgeRow, LandscapeFiles, Manifest, MinimumRow, Source};
use crate::topography::exchange::{Database, Layout, Reading, points};
use crate::topography::{Evidence, Families, FamilySettings, Network, Tree};

/// Coordinates of stationary points in the order of `min.data` and `ts.data`, all with the same number of coordinates. Both
/// lists are empty if they are unknown.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct StationaryCoordinates {
    /// Of each minimum.
    pub minima: Vec<Vec<f64>>,
    /// Of each transition state; empty if they are unknown.
    pub transition_states: Vec<Vec<f64>>,
}

/// A landscape of another program, from `min.data` and `ts.data` of PATHSAMPLE or topsearch.
#[derive(Debug)]
pub struct ImportedLandscape<'a> {
    database: &'a Database,
    layout: Layout,
    notes: Vec<String>,
    coordinates: StationaryCoordinates,
    network: Network,
    tree: Tree,
    families: Families,
    source: Source,
    command: &'a str,
}

impl<'a> ImportedLandscape<'a> {
    /// Builds tree and families. `source` names the folder, and `command` is the command line that repeats the import.
    ///
    /// # Panics
    /// If there are coordinates, but not one point for each minimum (or transition state).
    pub fn new(
        read: &'a Reading,
        coordinates: StationaryCoordinates,
        families: &FamilySettings,
        source: Source,
        command: &'a str,
    ) -> Self {
        let known = [&coordinates.minima, &coordinates.transition_states];
        let database = &read.database;
        let expected = [database.minima.len(), database.transition_states.len()];
        for (points, expected) in known.into_iter().zip(expected) {
            assert!(
                points.is_empty() || points.len() == expected,
                "one point for each row"
            );
        }
        let network = database.network();
        Self {
            tree: Tree::from_network(&network, Evidence::Chain),
            families: Families::new(&network, families),
            network,
            database: &read.database,
            layout: read.layout,
            notes: read.notes.clone(),
            coordinates,
            source,
            command,
        }
    }

    /// Adds a sentence to the warnings, without capital and full stop.
    #[must_use]
    pub fn noting(mut self, note: String) -> Self {
        self.notes.push(note);
        self
    }

    /// Writes the tables, pictures, texts and summary of `landscape import` into `folder`.
    ///
    /// # Errors
    /// If the folder cannot be written, or a number is not finite.
    pub fn write(&self, folder: &AtomicFolder) -> Result<WrittenLandscape, StudyError> {
        let files = self.files();
        files.write(folder)?;
        write_database(self.database, folder)?;
        let StationaryCoordinates {
            minima,
            transition_states,
        } = &self.coordinates;
        for (name, rows) in [("points.min", minima), ("points.ts", transition_states)] {
            if !rows.is_empty() {
                folder.write(name, &points(rows.iter().map(Vec::as_slice)))?;
            }
        }
        self.draw(folder)?;
        let text = printable(&self.summary(), &['\n', '\t']).into_owned();
        folder.write("summary.md", text.as_bytes())?;
        Ok(WrittenLandscape {
            files,
            text,
            ..WrittenLandscape::default()
        })
    }

    fn loops(&self) -> usize {
        let states = self.database.transition_states.iter();
        states
            .filter(|state| state.ends[0] == state.ends[1])
            .count()
    }

    fn minima(&self) -> Vec<MinimumRow> {
        let rows = self
            .network
            .node_weights()
            .zip(self.families.family_of())
            .enumerate();
        rows.map(|(id, (minimum, family))| MinimumRow {
            id: id as u64,
            energy: minimum.energy,
            // Each minimum of the network has one member, which is its row in the file.
            coordinates: (self.coordinates.minima)
                .get(minimum.members[0])
                .cloned()
                .unwrap_or_default(),
            members: minimum.members.iter().map(|row| *row as u64).collect(),
            family: family as u64,
            labels: BTreeMap::new(),
        })
        .collect()
    }

    fn edges(&self) -> Vec<EdgeRow> {
        (self.network.edge_references())
            .map(|edge| {
                let ends = [edge.source(), edge.target()];
                let [one, other] = ends.map(|end| self.network[end].energy);
                let height = edge.weight().height;
                EdgeRow {
                    a: ends[0].index() as u64,
                    b: ends[1].index() as u64,
                    height: Some(height),
                    relative_barrier: Some(height - one.max(other)),
                    evidence: edge.weight().evidence.name().to_owned(),
                    ..EdgeRow::default()
                }
            })
            .collect()
    }

    fn files(&self) -> LandscapeFiles {
        let (minima, edges) = (self.minima(), self.edges());
        let findings = [
            (
                "transition_states",
                json!(self.database.transition_states.len()),
            ),
            ("degenerate_rearrangements", json!(self.loops())),
            ("family_scan", super::json(&self.families.scan)),
        ];
        let manifest = Manifest {
            program_version: env!("CARGO_PKG_VERSION").to_owned(),
            command: self.command.to_owned(),
            source: self.source.clone(),
            scale: 1.0,
            energy: json!({ "imported": self.layout.name() }),
            family_barrier: Some(self.families.barrier),
            counts: Counts {
                minima: minima.len() as u64,
                families: self.families.members.len() as u64,
                pairs: edges.len() as u64,
                components: self.tree.roots.len() as u64,
                ..Counts::default()
            },
            evidence: BTreeMap::from([(Evidence::Given.name().to_owned(), edges.len() as u64)]),
            findings: findings
                .map(|(name, value)| (name.to_owned(), value))
                .into(),
            warnings: self.warnings(),
            ..Manifest::default()
        };
        LandscapeFiles {
            manifest,
            minima,
            edges,
            paths: Vec::new(),
        }
    }

    fn warnings(&self) -> Vec<String> {
        let unverified =
            "transition states are taken from the files and were not verified".to_owned();
        let unverified = (!self.database.transition_states.is_empty()).then_some(unverified);
        unverified
            .into_iter()
            .chain(self.notes.iter().cloned())
            .collect()
    }

    fn draw(&self, folder: &AtomicFolder) -> Result<(), StudyError> {
        let titles = Titles::of_surface(self.source.name.clone(), "members", 0);
        let leaves = leaves_of(&self.network);
        let drawing = Drawing {
            family_of: self.families.family_of(),
            ..Drawing::new(&self.network, &self.tree, leaves, &titles)
        };
        drawing.write(&mut |name, bytes| folder.write(name, bytes))
    }

    fn summary(&self) -> String {
        let mut text = format!(
            "# {}\n\n- **{}** and **{}** in the layout of {}{}; {}\n- {} of minima joined directly\n- {} (relative barrier \
             up to {})\n",
            self.source.name,
            counted(self.database.minima.len(), "minimum"),
            counted(self.database.transition_states.len(), "transition state"),
            self.layout.name(),
            match self.loops() {
                0 => String::new(),
                1 => ", 1 of which joins two copies of one minimum".to_owned(),
                loops => format!(", {loops} of which join two copies of one minimum"),
            },
            counted(self.tree.roots.len(), "component"),
            counted(self.network.edge_count(), "pair"),
            counted(self.families.members.len(), "family"),
            Digits::of([self.families.barrier]).show(self.families.barrier)
        );
        for warning in self.warnings() {
            text.extend(["- ", &warning, "\n"]);
        }
        if let Some(sentence) = not_drawn(self.database.minima.len()) {
            text.extend(["- ", &sentence, "\n"]);
        }
        text
    }
}
