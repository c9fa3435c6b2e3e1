//! One landscape on a page.

use std::collections::BTreeMap;

use rayon::prelude::*;
use serde_json::{Value, json};

use super::labels::{Key, labels};
use super::pack::Pack;
use super::touch::{epsilon_of, packed, touches};
use super::ways::{Ways, copy};
use super::{Scenes, hand, subject, surface, tree, trust};
use crate::energy::{Energy, Explain};
use crate::evaluation::taxonomy::Rule;
use crate::grasp::{Grasp, GraspEnergy};
use crate::hand::Hand;
use crate::object::Object;
use crate::store::{LandscapeFiles, MinimumRow};
use crate::study::drawing::Titles;
use crate::study::error::StudyError;
use crate::study::names::GraspSetting;
use crate::topography::{Attempts, Evidence, Match, Network, Tree};

/// Greatest number of touched places of a minimum, and if there are more than [`MANY`] minima.
const TOUCHES: [usize; 2] = [24, 8];
const MANY: usize = 1000;

/// A landscape to be shown on a page.
#[derive(Debug, Clone, Copy)]
pub struct PageLandscape<'a> {
    /// Its name, as in the command that shows it; empty for the page in its own folder, which tells the name.
    pub name: &'a str,
    /// Its tables.
    pub files: &'a LandscapeFiles,
    /// The searches, for the support of merges; empty if unknown.
    pub attempts: &'a Attempts,
    /// Whether grasps held in simulation, by id; empty if none was simulated.
    pub held: &'a BTreeMap<u64, bool>,
    /// Its energy, if it is at hand; otherwise that of a landscape of grasps is built from its manifest.
    pub energy: Option<&'a GraspEnergy>,
}

impl PageLandscape<'_> {
    /// The landscape as an entry of the header.
    ///
    /// If it stands beside another one, `guide` has the minima of that one and those of this one that correspond to them,
    /// which are turned to stand like them.
    pub(super) fn side(
        &self,
        scenes: &mut Scenes,
        pack: &mut Pack,
        guide: Option<(&[Vec<f64>], &[Match])>,
    ) -> Result<(Value, Vec<Vec<f64>>), StudyError> {
        let Self { name, files, .. } = *self;
        let network = files.network(name.as_ref())?;
        let merges = Tree::from_network(&network, Evidence::Chain);
        let manifest = &files.manifest;
        let titles = Titles::of_manifest(manifest, None);
        let energies: Vec<f64> = files.minima.iter().map(|row| row.energy).collect();
        let mut side = json!({
            "name": name,
            "title": titles.title,
            "item": "minimum",
            "command": manifest.command,
            "program": manifest.program_version,
            "energy_label": titles.energy,
            "members_label": titles.members,
            "family_barrier": manifest.family_barrier,
            "letting_go": manifest.letting_go,
            "count": files.minima.len(),
            "energy": pack.doubles(&energies),
            "members": self.members(),
            "member_count": pack.wholes(files.minima.iter().map(|row| row.members.len())),
            "family": tree::families(&files.minima, pack),
            "families": manifest.counts.families,
            "family_names": manifest.findings.get("family_names"),
            "tree": tree::tree(&merges, self.attempts, pack),
            "graph": tree::graph(files, &network, &merges, pack)?,
            "trust": trust::statements(files, &merges, self.attempts),
            "rarefaction": manifest.findings.get("rarefaction"),
        });
        let (shown, minima) = if manifest.hand.is_some() && manifest.object.is_some() {
            self.grasps(&network, scenes, pack, guide)?
        } else {
            self.points(&network, pack)
        };
        if let (Value::Object(side), Value::Object(shown)) = (&mut side, shown) {
            side.extend(shown);
        }
        Ok((side, minima))
    }

    /// Ids of the grasps of each minimum; only of landscapes of grasps, where ids mean something to the reader.
    fn members(&self) -> Vec<String> {
        let ids = |row: &MinimumRow| {
            let ids: Vec<String> = row.members.iter().map(u64::to_string).collect();
            ids.join(" ")
        };
        let of_grasps = self.files.manifest.hand.is_some();
        let rows = self.files.minima.iter().filter(|_| of_grasps);
        rows.map(ids).collect()
    }

    /// What is particular to grasps.
    fn grasps(
        &self,
        network: &Network,
        scenes: &mut Scenes,
        pack: &mut Pack,
        guide: Option<(&[Vec<f64>], &[Match])>,
    ) -> Result<(Value, Vec<Vec<f64>>), StudyError> {
        let Self { name, files, .. } = *self;
        let built;
        let energy = if let Some(energy) = self.energy {
            energy
        } else {
            built = GraspSetting::of(files, name)?.energy(files, name)?;
            &built
        };
        let setting = GraspSetting {
            hand: energy.hand().clone(),
            object: energy.object().clone(),
        };
        let (object, scale) = (&files.manifest.object, files.manifest.scale);
        let object_name = object.as_ref().map_or("", |object| object.name.as_str());
        let hand_name = files
            .manifest
            .hand
            .as_ref()
            .map_or("", |hand| hand.name.as_str());
        let scene = scenes.add(
            pack,
            (hand_name, &setting.hand),
            (object_name, scale, &*setting.object),
        );
        let names = setting.names(files, Rule::standard()).into_iter();
        let named: Vec<_> = files
            .minima
            .iter()
            .map(MinimumRow::label)
            .zip(names)
            .collect();
        let space = energy.space();
        let ways = Ways::of(files, network, space);
        let mut side = json!({
            "space": {
                "kind": "pose",
                "dimensions": space.coordinates(),
            },
            "scene": scene,
            "key": self.key(),
            "subject": subject(hand_name, object_name, scale),
            "coordinates": pack.floats(&ways.minima.concat()),
            "term_names": energy.term_names(),
            "ways": ways.packed(files, space, Some(energy), pack),
            "stable": pack.bytes(files.minima.iter().map(|row| self.stability(row))),
            "friction": energy.settings().layer.friction,
        });
        let measured = measured(files, energy, &ways, pack);
        let labels = labels(&named, pack);
        for more in [measured, labels] {
            if let (Value::Object(side), Value::Object(more)) = (&mut side, more) {
                side.extend(more);
            }
        }
        if let Some((others, matches)) = guide {
            let turned = matches.iter().flat_map(|pair| {
                let (before, after) = (&others[pair.before.0], &ways.minima[pair.after.0]);
                copy(space, before, after, false)
            });
            side["counterparts"] = pack.floats(&turned.collect::<Vec<_>>());
        }
        Ok((side, ways.minima))
    }

    /// The key of the labels in a browser.
    fn key(&self) -> String {
        let (mut key, manifest) = (Key::default(), &self.files.manifest);
        if let (Some(hand), Some(object)) = (&manifest.hand, &manifest.object) {
            for text in [
                &hand.name,
                &hand.content_hash,
                &object.name,
                &object.content_hash,
            ] {
                key.text(text);
            }
        }
        key.numbers(&[manifest.scale]);
        for (row, members) in self.files.minima.iter().zip(self.members()) {
            key.text(&members);
            key.numbers(&row.coordinates);
        }
        key.finish()
    }

    /// 1 if most simulated grasps of a minimum held, 0 if not, 2 if none was simulated.
    fn stability(&self, row: &MinimumRow) -> u8 {
        let known: Vec<bool> = (row.members.iter())
            .filter_map(|id| self.held.get(id).copied())
            .collect();
        let held = known.iter().filter(|held| **held).count();
        match known.len() {
            0 => 2,
            all => u8::from(2 * held >= all),
        }
    }

    /// What is particular to points of a surface.
    fn points(&self, network: &Network, pack: &mut Pack) -> (Value, Vec<Vec<f64>>) {
        let files = self.files;
        let dimensions = files.minima.first().map_or(0, |row| row.coordinates.len());
        let known = surface::space(&files.manifest);
        let Some((kind, space)) = known.filter(|(_, space)| space.coordinates() == dimensions)
        else {
            let none = json!({ "space": { "kind": "none", "dimensions": 0 } });
            return (none, Vec::new());
        };
        let ways = Ways::of(files, network, &*space);
        let side = json!({
            "space": {
                "kind": kind,
                "dimensions": dimensions,
                "contours": surface::contours(&files.manifest, pack),
            },
            "coordinates": pack.floats(&ways.minima.concat()),
            "ways": ways.packed(files, &*space, None, pack),
        });
        (side, ways.minima)
    }
}

/// Terms, ε and touched places of the minima.
fn measured(
    files: &LandscapeFiles,
    energy: &GraspEnergy,
    ways: &Ways<'_>,
    pack: &mut Pack,
) -> Value {
    let most = TOUCHES[usize::from(files.minima.len() > MANY)];
    let rows: Vec<_> = (files.minima.par_iter().zip(&ways.minima))
        .map(|(row, turned)| {
            let set = Grasp::best(energy, row.coordinates.clone());
            let terms = energy.terms(&row.coordinates).into_iter();
            let terms: Vec<f64> = terms.map(|(_, value)| value).collect();
            let shown = Grasp::new(turned.clone(), set.contacts.clone());
            (
                terms,
                epsilon_of(energy, &set),
                touches(energy, &shown, most),
            )
        })
        .collect();
    let terms: Vec<f64> = rows.iter().flat_map(|(terms, ..)| terms).copied().collect();
    let epsilons = rows.iter().map(|(_, epsilon, _)| Some(*epsilon));
    let epsilons = pack.known_floats(epsilons);
    let places: Vec<_> = rows.into_iter().map(|(.., places)| places).collect();
    json!({
        "terms": pack.floats(&terms),
        "epsilon": epsilons,
        "touches": packed(&places, pack),
    })
}

impl Scenes {
    /// Adds a hand and an object if they are new, and returns the number of their pair.
    pub(super) fn add(
        &mut self,
        pack: &mut Pack,
        (hand_name, model): (&str, &Hand),
        (object_name, scale, object): (&str, f64, &Object),
    ) -> usize {
        let same = |(known, packed): &(Hand, Value)| known == model && packed["name"] == hand_name;
        let hand = self.hands.iter().position(same).unwrap_or_else(|| {
            self.hands
                .push((model.clone(), hand::hand(hand_name, model, pack)));
            self.hands.len() - 1
        });
        let mesh = &object.mesh;
        let key = format!("{object_name} {scale} {:?}", mesh.bounds());
        let same = |(known, _): &(String, Value)| *known == key;
        let object = self.objects.iter().position(same).unwrap_or_else(|| {
            self.objects
                .push((key.clone(), hand::object(object_name, mesh, pack)));
            self.objects.len() - 1
        });
        let pair = [hand, object];
        let known = self.pairs.iter().position(|known| *known == pair);
        known.unwrap_or_else(|| {
            self.pairs.push(pair);
            self.pairs.len() - 1
        })
    }
}
