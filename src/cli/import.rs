//! `landscape import`: `min.data` and `ts.data` of PATHSAMPLE or topsearch as a landscape; grasps elsewhere.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::{Context, ensure};
use petgraph::visit::EdgeRef;
use serde_json::{Value, json};

use super::args::{Common, Import};
use super::digits::Digits;
use super::drawing::{Drawing, Views, not_drawn};
use super::landscape::{Titles, write_database};
use super::output::{check_inputs, check_place};
use super::provenance::name_of;
use super::{complain, import_grasps, print};
use crate::figure::leaves_of;
use crate::store::{
    AtomicFolder, Counts, EdgeRow, LandscapeFiles, Manifest, MinimumRow, Source, content_hash,
};
use crate::topography::exchange::{Database, Layout};
use crate::topography::{Evidence, GroupSettings, Groups, Network, Tree};

pub(super) fn run(command: &Import, common: &Common) -> anyhow::Result<()> {
    let group_barrier = command.groups.checked()?;
    if import_grasps::holds_grasps(&command.path) {
        ensure!(
            group_barrier.is_none(),
            "--group-barrier is for min.data and ts.data: grasps have groups only once `landscape build` mapped them"
        );
        return import_grasps::run(command, common);
    }
    ensure!(
        command.hand.is_none() && command.object.is_none(),
        "{}: --hand and --object are for grasps, of which there are none",
        command.path.display()
    );
    let texts = ["min.data", "ts.data"].map(|name| read(&command.path, name));
    let [minima, states] = texts;
    let (minima, states) = (minima?, states?);
    let (database, layout) =
        Database::parse(&minima, &states).with_context(|| command.path.display().to_string())?;
    let output = match &command.output {
        Some(output) => output.clone(),
        None => named_after(&command.path)?,
    };
    check_place(&output)?;
    check_inputs(&output, &[&command.path])?;
    let network = database.network();
    let groups = GroupSettings {
        barrier: group_barrier,
        ..GroupSettings::default()
    };
    let imported = Imported {
        tree: Tree::from_network(&network, Evidence::Chain),
        groups: Groups::new(&network, &groups),
        network,
        layout,
        database: &database,
        source: Source {
            name: name_of(&command.path),
            content_hash: content_hash(&[minima.as_bytes(), states.as_bytes()]),
        },
        command: &common.provenance.command,
    };
    let folder = AtomicFolder::open(&output, true)?;
    imported.files()?.write(&folder)?;
    write_database(&database, &folder)?;
    imported.draw(&folder)?;
    let text = super::shown(&imported.summary());
    folder.write("summary.md", text.as_bytes())?;
    let finished = folder.finish()?;
    if !common.quiet {
        print(&text);
        complain(&format!("wrote {}", finished.display()));
    }
    Ok(())
}

fn read(folder: &Path, name: &str) -> anyhow::Result<String> {
    ensure!(
        folder.is_dir(),
        "{} is no folder: min.data and ts.data are read from one",
        folder.display()
    );
    let path = folder.join(name);
    let bytes = std::fs::read(&path).with_context(|| format!("cannot read {}", path.display()))?;
    String::from_utf8(bytes).with_context(|| format!("{} is not text", path.display()))
}

/// `folder` becomes `folder.landscape` in the place where the command runs.
fn named_after(folder: &Path) -> anyhow::Result<PathBuf> {
    let name = name_of(folder);
    ensure!(
        !name.is_empty(),
        "{}: name the folder to write with --output",
        folder.display()
    );
    Ok(PathBuf::from(format!("{name}.landscape")))
}

/// What was read and what it comes to.
struct Imported<'a> {
    database: &'a Database,
    layout: Layout,
    network: Network,
    tree: Tree,
    groups: Groups,
    source: Source,
    command: &'a str,
}

impl Imported<'_> {
    fn loops(&self) -> usize {
        let states = self.database.transition_states.iter();
        states
            .filter(|state| state.ends[0] == state.ends[1])
            .count()
    }

    fn files(&self) -> anyhow::Result<LandscapeFiles> {
        let rows = self
            .network
            .node_weights()
            .zip(self.groups.group_of())
            .enumerate();
        let minima: Vec<MinimumRow> = rows
            .map(|(id, (minimum, group))| MinimumRow {
                id: id as u64,
                energy: minimum.energy,
                coordinates: Vec::new(),
                choice: Vec::new(),
                members: minimum.members.iter().map(|row| *row as u64).collect(),
                group: group as u64,
                labels: BTreeMap::new(),
            })
            .collect();
        let edges: Vec<EdgeRow> = (self.network.edge_references())
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
            .collect();
        let findings = [
            (
                "transition_states",
                json!(self.database.transition_states.len()),
            ),
            ("degenerate_rearrangements", json!(self.loops())),
            ("group_scan", serde_json::to_value(&self.groups.scan)?),
        ];
        let manifest = Manifest {
            program_version: env!("CARGO_PKG_VERSION").to_owned(),
            command: self.command.to_owned(),
            seed: 0,
            source: self.source.clone(),
            hand: None,
            object: None,
            scale: 1.0,
            energy: json!({ "imported": self.layout.name() }),
            settings: Value::Null,
            terms: Vec::new(),
            group_barrier: Some(self.groups.barrier),
            counts: Counts {
                grasps: 0,
                minima: minima.len() as u64,
                groups: self.groups.members.len() as u64,
                pairs: edges.len() as u64,
                components: self.tree.roots.len() as u64,
                evaluations: 0,
            },
            evidence: BTreeMap::from([("saddle".to_owned(), edges.len() as u64)]),
            findings: findings
                .map(|(name, value)| (name.to_owned(), value))
                .into(),
            warnings: vec![
                "transition states are taken at the word of the files: nothing was verified"
                    .to_owned(),
            ],
        };
        Ok(LandscapeFiles {
            manifest,
            minima,
            edges,
            paths: Vec::new(),
        })
    }

    fn draw(&self, folder: &AtomicFolder) -> anyhow::Result<()> {
        let drawing = Drawing {
            network: &self.network,
            tree: &self.tree,
            resampled: &[],
            leaves: leaves_of(&self.network),
            group_of: self.groups.group_of(),
            titles: &Titles {
                title: self.source.name.clone(),
                energy: "energy",
                members: "members",
                seed: 0,
            },
            views: Views::default(),
            examples: Vec::new(),
        };
        drawing.write(&mut |name, bytes| folder.write(name, bytes))
    }

    fn summary(&self) -> String {
        let mut text = format!(
            "# {}\n\n- **{} minima** and **{} transition states** in the layout of {}, {} of which join two copies of \
             one minimum; {} component(s)\n- {} pairs of minima are joined directly\n- {} groups (relative barrier up to \
             {})\n- transition states are taken at the word of the files: nothing was verified\n",
            self.source.name,
            self.database.minima.len(),
            self.database.transition_states.len(),
            self.layout.name(),
            self.loops(),
            self.tree.roots.len(),
            self.network.edge_count(),
            self.groups.members.len(),
            Digits::of([self.groups.barrier]).show(self.groups.barrier)
        );
        if let Some(sentence) = not_drawn(self.database.minima.len()) {
            text.extend(["- ", &sentence, "\n"]);
        }
        text
    }
}
