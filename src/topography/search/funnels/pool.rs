//! The minima and saddles found so far, and which of them are the same.

use serde::{Deserialize, Serialize};

use crate::energy::Energy;
use crate::space::Space;
use crate::topography::audit::{Audit, AuditSettings, examine};
use crate::topography::journal::bits;
use crate::topography::minima::MatchTolerance;
use crate::topography::path::Path;
use crate::topography::search::Refused;
use crate::topography::search::census::Shelf;
use crate::topography::search::flat::{Bottom, same_bottom};

/// Number of nearest minima, by landmarks, that each minimum remembers.
const NEIGHBOURS: usize = 12;

/// A minimum.
pub(super) struct Site {
    pub(super) x: Vec<f64>,
    pub(super) energy: f64,
    pub(super) audit: Audit,
    pub(super) landmarks: Vec<f64>,
    /// Hops that ended here.
    pub(super) draws: Vec<usize>,
    /// Climbs that began here.
    pub(super) climbs: usize,
    /// Those of them that found an unknown saddle.
    pub(super) news: usize,
    /// Numbers of the nearest minima, by landmarks, with the lower bound of the distance; nearest first.
    pub(super) neighbours: Vec<(f64, usize)>,
}

impl Site {
    fn bottom(&self) -> Bottom<'_> {
        Bottom {
            x: &self.x,
            energy: self.energy,
            audit: &self.audit,
        }
    }
}

/// A saddle.
pub(super) struct Gate {
    pub(super) x: Vec<f64>,
    pub(super) energy: f64,
    pub(super) audit: Audit,
    pub(super) ends: [usize; 2],
    /// From the first end over the saddle to the second.
    pub(super) path: Path,
    pub(super) top: usize,
    pub(super) hits: usize,
}

/// Where a descent from a saddle ended.
#[derive(Serialize, Deserialize)]
pub(super) enum End {
    /// In a minimum that was known when the task began.
    Known(usize),
    /// In another minimum, which passed its audit.
    New(Found),
}

/// A point that passed its audit.
#[derive(Clone, Serialize, Deserialize)]
pub(super) struct Found {
    #[serde(with = "bits::list")]
    pub(super) x: Vec<f64>,
    #[serde(with = "bits::number")]
    pub(super) energy: f64,
    pub(super) audit: Audit,
}

/// A saddle that was unknown when its task began, and the ends of both descents.
#[derive(Serialize, Deserialize)]
pub(super) struct Crossed {
    pub(super) saddle: Found,
    pub(super) ends: [End; 2],
    pub(super) path: Path,
    pub(super) top: usize,
}

pub(super) struct Pool<'a> {
    pub(super) energy: &'a dyn Energy,
    pub(super) sites: Vec<Site>,
    pub(super) gates: Vec<Gate>,
    pub(super) audit: AuditSettings,
    sameness: MatchTolerance,
    by_energy: [Shelf; 2],
}

impl<'a> Pool<'a> {
    pub(super) fn new(
        energy: &'a dyn Energy,
        audit: AuditSettings,
        sameness: MatchTolerance,
    ) -> Self {
        Self {
            energy,
            sites: Vec::new(),
            gates: Vec::new(),
            audit,
            sameness,
            by_energy: [Shelf::default(), Shelf::default()],
        }
    }

    fn space(&self) -> &'a dyn Space {
        self.energy.space()
    }

    /// The known minimum at `x`.
    pub(super) fn site(&self, x: &[f64], energy: f64) -> Option<usize> {
        self.by_energy[0]
            .near(energy, self.sameness.energy)
            .find(|k| (self.space()).within(&self.sites[*k].x, x, self.sameness.distance))
    }

    /// The known saddle at `x`.
    pub(super) fn gate(&self, x: &[f64], energy: f64) -> Option<usize> {
        self.by_energy[1]
            .near(energy, self.sameness.energy)
            .find(|k| (self.space()).within(&self.gates[*k].x, x, self.sameness.distance))
    }

    /// The point with its audit, if it passes.
    pub(super) fn examined(
        &self,
        x: Vec<f64>,
        expected_index: usize,
        search: usize,
    ) -> Result<Found, Refused> {
        let (energy, audit) = examine(self.energy, &x, expected_index, &self.audit);
        if audit.verdict.is_stationary() {
            Ok(Found { x, energy, audit })
        } else {
            Err(Refused {
                search,
                expected_index,
                energy,
                audit,
            })
        }
    }

    /// The number of a minimum, which is added if it is new.
    pub(super) fn put(&mut self, found: Found) -> usize {
        if let Some(known) = self.site(&found.x, found.energy) {
            return known;
        }
        let alike = self.by_energy[0].near(found.energy, self.sameness.energy);
        let alike = alike.map(|k| (k, self.sites[k].bottom()));
        let new = Bottom {
            x: &found.x,
            energy: found.energy,
            audit: &found.audit,
        };
        if let Some(known) = same_bottom(self.energy, &new, alike, &self.audit) {
            return known;
        }
        let landmarks = self.space().landmarks(&found.x);
        let number = self.sites.len();
        let mut neighbours = Vec::new();
        for (other, site) in self.sites.iter_mut().enumerate() {
            let bound = bound(
                self.energy.space(),
                (&site.landmarks, &landmarks),
                (&site.x, &found.x),
            );
            remember(&mut site.neighbours, (bound, number));
            remember(&mut neighbours, (bound, other));
        }
        self.by_energy[0].insert(found.energy, number);
        self.sites.push(Site {
            x: found.x,
            energy: found.energy,
            audit: found.audit,
            landmarks,
            draws: Vec::new(),
            climbs: 0,
            news: 0,
            neighbours,
        });
        number
    }

    /// Adds a saddle and the minima that it joins. Returns whether the saddle is new.
    pub(super) fn join(&mut self, crossed: Crossed, hits: usize) -> bool {
        let Crossed {
            saddle,
            ends,
            path,
            top,
        } = crossed;
        if let Some(known) = self.gate(&saddle.x, saddle.energy) {
            self.gates[known].hits += hits;
            return false;
        }
        let ends = ends.map(|end| match end {
            End::Known(number) => number,
            End::New(found) => self.put(found),
        });
        self.by_energy[1].insert(saddle.energy, self.gates.len());
        self.gates.push(Gate {
            x: saddle.x,
            energy: saddle.energy,
            audit: saddle.audit,
            ends,
            path,
            top,
            hits,
        });
        true
    }

    /// Numbers of the minima, lowest first.
    pub(super) fn by_energy(&self) -> impl Iterator<Item = usize> {
        self.by_energy[0].0.iter().map(|(_, number)| *number)
    }

    /// Numbers of the saddles, lowest first.
    pub(super) fn gates_by_energy(&self) -> impl Iterator<Item = usize> {
        self.by_energy[1].0.iter().map(|(_, number)| *number)
    }

    /// A lower bound of the distance of two minima (the distance itself on a space without landmarks).
    pub(super) fn bound(&self, a: usize, b: usize) -> f64 {
        let (a, b) = (&self.sites[a], &self.sites[b]);
        bound(self.space(), (&a.landmarks, &b.landmarks), (&a.x, &b.x))
    }
}

fn bound(space: &dyn Space, landmarks: (&[f64], &[f64]), x: (&[f64], &[f64])) -> f64 {
    if landmarks.0.is_empty() {
        return space.distance(x.0, x.1);
    }
    let pairs = landmarks.0.iter().zip(landmarks.1);
    pairs.map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}

/// Keeps the nearest neighbours, nearest first.
fn remember(neighbours: &mut Vec<(f64, usize)>, new: (f64, usize)) {
    let place = neighbours.partition_point(|(bound, _)| *bound <= new.0);
    if place < NEIGHBOURS {
        neighbours.insert(place, new);
        neighbours.truncate(NEIGHBOURS);
    }
}
