//! Claims H1 to H6 and H8, which need only heights and labels.

use super::{ClaimSettings, Finding, Verdict, insufficient};
use landscape::agreement::{
    Correlation, Dendrogram, Outcome, Permutations, Tested, anosim_of_ranks, barrier_ratio,
    bootstrap, cliffs_delta, indicator, mantel, morans_i, partial_mantel, test_labels,
    test_uncertain_labels,
};
use landscape::evaluation::taxonomy::{Category, Rule, Taxonomy};
use landscape::study::{Basin, Basins, Part, StatisticsSettings};

const POWER: usize = Category::Power as usize;
const INTERMEDIATE: usize = Category::Intermediate as usize;
const PRECISION: usize = Category::Precision as usize;

pub(super) fn examine(
    basins: &Basins,
    claims: &ClaimSettings,
    rule: &Rule,
    seed: u64,
) -> Vec<Finding> {
    let settings = &claims.statistics;
    let asked = Asked {
        basins,
        claims,
        settings,
        permutations: settings.permutations(seed),
        seed,
    };
    vec![
        asked.alike(),
        asked.all(),
        asked.apart(),
        asked.scattered(),
        asked.unlisted(rule),
        asked.nearest(),
        asked.tripods(),
    ]
}

struct Asked<'a> {
    basins: &'a Basins,
    claims: &'a ClaimSettings,
    settings: &'a StatisticsSettings,
    permutations: Permutations,
    seed: u64,
}

impl Asked<'_> {
    fn alike(&self) -> Finding {
        let asked = &self.claims.alike;
        let heights = self.basins.saddles.raised(self.settings.censored_factor);
        let blocks = vec![0; self.basins.minima.len()];
        if self.basins.inapplicable.is_some() || blocks.len() < self.settings.least_per_class {
            return insufficient(
                "H1",
                &asked.claim,
                "too few minima, or a hand without the regions of a human one",
            );
        }
        let spearman = Correlation::Spearman;
        let contacts = mantel(
            &heights,
            &self.basins.contact_distances,
            spearman,
            &blocks,
            &self.permutations,
        );
        let gaps = partial_mantel(
            &heights,
            &self.basins.contact_distances,
            &self.basins.energy_gaps,
            spearman,
            &blocks,
            &self.permutations,
        );
        let pose = mantel(
            &heights,
            &self.basins.pose_distances,
            spearman,
            &blocks,
            &self.permutations,
        );
        let holds = contacts.statistic >= asked.least_correlation && contacts.p < asked.level;
        Finding::new(
            "H1",
            &asked.claim,
            Verdict::of(holds),
            Some(contacts.p),
            format!(
                "Mantel's rank correlation of saddle heights with distances of contact areas {:.3} (p {:.4}), given the \
                 gap in energy {:.3} (p {:.4}); control: with distances of poses {:.3} (p {:.4})",
                contacts.statistic, contacts.p, gaps.statistic, gaps.p, pose.statistic, pose.p
            ),
        )
    }

    fn all(&self) -> Finding {
        let asked = &self.claims.all;
        let total: f64 = self.basins.minima.iter().map(|basin| basin.grasps).sum();
        let mut holds = self.basins.inapplicable.is_none();
        let mut parts = Vec::new();
        for category in [Category::Power, Category::Intermediate, Category::Precision] {
            let own = || {
                self.basins
                    .minima
                    .iter()
                    .filter(|basin| basin.unfiltered == Some(category as usize))
            };
            // Starts from 0, since an empty sum is −0.
            let share = own()
                .map(|basin| basin.grasps)
                .fold(0.0, |sum, grasps| sum + grasps)
                / total;
            let minima = own().count();
            holds &= share >= asked.least_share && minima >= asked.least_minima;
            parts.push(format!(
                "{} {:.1} % ({minima} minima)",
                category.name(),
                100.0 * share
            ));
        }
        let verdict = if self.basins.inapplicable.is_none() {
            Verdict::of(holds)
        } else {
            Verdict::Insufficient
        };
        Finding::new(
            "H2",
            &asked.claim,
            verdict,
            None,
            format!(
                "of the grasps, by the type that fits best: {}",
                parts.join(", ")
            ),
        )
    }

    fn apart(&self) -> Finding {
        let asked = &self.claims.apart;
        let label = |basin: &Basin| match basin.category {
            Some(POWER) => Some(0),
            Some(PRECISION) => Some(1),
            _ => None,
        };
        let part = Part::new(self.basins, self.settings, label);
        let ratio = barrier_ratio(&part.barriers, &part.labels, [0, 1]);
        let ranks = part.saddles.ranks();
        let tree = Dendrogram::new(&part.saddles);
        let anosim = test_labels(&part.labels, &part.blocks, &self.permutations, |labels| {
            anosim_of_ranks(&ranks, labels)
        });
        let purity = test_labels(&part.labels, &part.blocks, &self.permutations, |labels| {
            tree.purity(labels, &part.weights)
        });
        let (Outcome::Known(anosim), Outcome::Known(purity)) = (anosim, purity) else {
            return insufficient(
                "H3",
                &asked.claim,
                &few(&part.labels, &["power", "precision"]),
            );
        };
        let quick = Permutations {
            count: self.settings.label_permutations,
            ..self.permutations
        };
        let weights: Vec<Vec<f64>> = part
            .cases
            .iter()
            .map(|&i| self.drawn(i, part_label(&part, i)))
            .collect();
        let unsure = test_uncertain_labels(
            &weights,
            &part.blocks,
            self.settings.label_draws,
            &quick,
            |labels| anosim_of_ranks(&ranks, labels),
        );
        let [low, high] = unsure.statistic.interval(0.95);
        let holds = ratio.ratio >= asked.least_ratio
            && anosim.statistic >= asked.least_anosim
            && anosim.p < asked.level
            && purity.p < asked.purity_level;
        Finding::new(
            "H3",
            &asked.claim,
            Verdict::of(holds),
            Some(anosim.p),
            format!(
                "median relative barrier between over within {:.2} (Cliff's delta {:.2}; {} and {} pairs); ANOSIM R {:.3} \
                 (p {:.4}; with labels drawn anew {low:.3} to {high:.3}); dendrogram purity {:.3} (chance {:.3}, p {:.4})",
                ratio.ratio,
                ratio.delta,
                ratio.between,
                ratio.within,
                anosim.statistic,
                anosim.p,
                purity.statistic,
                purity.chance,
                purity.p
            ),
        )
    }

    /// Weights of power (0) and precision (1) of a minimum, from its best-fitting types.
    fn drawn(&self, case: usize, label: usize) -> Vec<f64> {
        let taxonomy = Taxonomy::feix();
        let best = &self.basins.minima[case].best;
        let first = best.first().map_or(0.0, |first| first.score);
        let mut weights = vec![0.0; 2];
        for candidate in best {
            let category = taxonomy
                .numbered(candidate.number)
                .map(|entry| entry.category as usize);
            let weight = libm::exp((candidate.score - first) / self.settings.label_temperature);
            match category {
                Some(POWER) => weights[0] += weight,
                Some(PRECISION) => weights[1] += weight,
                _ => {}
            }
        }
        if weights.iter().all(|weight| *weight == 0.0) {
            weights[label] = 1.0;
        }
        weights
    }

    fn scattered(&self) -> Finding {
        let asked = &self.claims.scattered;
        let part = Part::new(self.basins, self.settings, |basin| basin.category);
        let graph = part.graph(self.basins.group_barrier);
        let counts = [POWER, INTERMEDIATE, PRECISION]
            .map(|class| part.labels.iter().filter(|label| **label == class).count());
        if counts[INTERMEDIATE] < self.settings.least_per_class {
            return insufficient(
                "H4",
                &asked.claim,
                &format!("{} intermediate minima", counts[INTERMEDIATE]),
            );
        }
        let interval = |class: usize| {
            let drawn = bootstrap(
                &part.blocks,
                self.settings.bootstrap_draws,
                self.seed,
                |cases| {
                    let labels: Vec<usize> = cases.iter().map(|&i| part.labels[i]).collect();
                    morans_i(&graph.chosen(cases, 0.0), &indicator(&labels, class))
                },
            );
            drawn.interval(0.95)
        };
        let [power, own, precision] = [POWER, INTERMEDIATE, PRECISION].map(interval);
        let two: Vec<usize> = part
            .labels
            .iter()
            .map(|label| usize::from(*label == INTERMEDIATE))
            .collect();
        let tested = test_labels(&two, &part.blocks, &self.permutations, |labels| {
            morans_i(&graph, &indicator(labels, 1))
        });
        let p = tested.known().map(|tested| tested.p);
        let below = own[1] < power[0] && own[1] < precision[0];
        let chance =
            p.is_some_and(|p| p > asked.level) && counts[INTERMEDIATE] >= asked.least_minima;
        Finding::new(
            "H4",
            &asked.claim,
            Verdict::of(below || chance),
            p,
            format!(
                "Moran's I of intermediate {:.3} to {:.3}, of power {:.3} to {:.3}, of precision {:.3} to {:.3} (95 %)",
                own[0], own[1], power[0], power[1], precision[0], precision[1]
            ),
        )
    }

    fn unlisted(&self, rule: &Rule) -> Finding {
        let asked = &self.claims.unlisted;
        let total: f64 = self.basins.minima.iter().map(|basin| basin.grasps).sum();
        let share = |threshold: f64| {
            let own = self
                .basins
                .minima
                .iter()
                .filter(|basin| basin.fit < threshold);
            own.map(|basin| basin.grasps).sum::<f64>() / total
        };
        let here = share(rule.unlisted_below);
        let others = asked.other_thresholds.map(share);
        let holds = (asked.share[0]..=asked.share[1]).contains(&here)
            && others.iter().all(|share| *share > 0.0);
        let verdict = if self.basins.inapplicable.is_none() {
            Verdict::of(holds)
        } else {
            Verdict::Insufficient
        };
        Finding::new(
            "H5",
            &asked.claim,
            verdict,
            None,
            format!(
                "{:.1} % of the grasps fit no type better than {}; {:.1} % below {}, {:.1} % below {} (a person has not looked at them)",
                100.0 * here,
                rule.unlisted_below,
                100.0 * others[0],
                asked.other_thresholds[0],
                100.0 * others[1],
                asked.other_thresholds[1]
            ),
        )
    }

    fn nearest(&self) -> Finding {
        let asked = &self.claims.nearest;
        let precision = self.basins.cases(|basin| basin.category == Some(PRECISION));
        let part = Part::new(self.basins, self.settings, |basin| {
            let number = basin.grasp_type?;
            match () {
                () if asked.others.contains(&number) => Some(0),
                () if asked.spheres.contains(&number) => Some(1),
                () => None,
            }
        });
        let raised = self.basins.barriers.raised(self.settings.censored_factor);
        let least: Vec<f64> = (part.cases.iter())
            .map(|&i| {
                precision
                    .iter()
                    .filter(|j| **j != i)
                    .map(|&j| raised.get(i, j))
                    .fold(f64::INFINITY, f64::min)
            })
            .collect();
        let delta = |labels: &[usize]| {
            let of = |class: usize| -> Vec<f64> {
                least
                    .iter()
                    .zip(labels)
                    .filter(|(_, label)| **label == class)
                    .map(|(barrier, _)| *barrier)
                    .collect()
            };
            cliffs_delta(&of(1), &of(0))
        };
        let tested = test_labels(&part.labels, &part.blocks, &self.permutations, |labels| {
            -delta(labels)
        });
        match tested {
            Outcome::Known(tested) if precision.len() >= self.settings.least_per_class => {
                let delta = -tested.statistic;
                Finding::new(
                    "H6",
                    &asked.claim,
                    Verdict::of(delta <= asked.most_delta && tested.p < asked.level),
                    Some(tested.p),
                    format!(
                        "Cliff's delta of the least barrier to a precision grasp, spheres over cylinders and disks: {delta:.2} (p {:.4})",
                        tested.p
                    ),
                )
            }
            _ => insufficient(
                "H6",
                &asked.claim,
                &format!(
                    "{}; {} precision minima",
                    few(&part.labels, &["cylinder or disk", "sphere"]),
                    precision.len()
                ),
            ),
        }
    }

    fn tripods(&self) -> Finding {
        let asked = &self.claims.tripods;
        let part = Part::new(self.basins, self.settings, |basin| {
            let number = basin.grasp_type?;
            Some(match () {
                () if asked.spheres.contains(&number) => 0,
                () if asked.near.contains(&number) => 1,
                () => 2,
            })
        });
        let ratio = |labels: &[usize]| {
            let mut sums = [[0.0; 2]; 2];
            for (i, j, barrier) in part.barriers.pairs() {
                let (low, high) = (labels[i].min(labels[j]), labels[i].max(labels[j]));
                if low == 0 && high > 0 {
                    let own: &mut [f64; 2] = &mut sums[high - 1];
                    own[0] += barrier;
                    own[1] += 1.0;
                }
            }
            (sums[0][0] / sums[0][1]) / (sums[1][0] / sums[1][1])
        };
        match test_labels(&part.labels, &part.blocks, &self.permutations, |labels| {
            -ratio(labels)
        }) {
            Outcome::Known(Tested { statistic, p, .. })
                if part.labels.contains(&1) && part.labels.contains(&0) =>
            {
                Finding::new(
                    "H8",
                    &asked.claim,
                    Verdict::of(-statistic <= asked.most_ratio && p < asked.level),
                    Some(p),
                    format!(
                        "mean barrier from spheres to tripods and quadpods over that to all other types {:.2} (p {p:.4})",
                        -statistic
                    ),
                )
            }
            _ => insufficient(
                "H8",
                &asked.claim,
                &few(&part.labels, &["sphere", "tripod or quadpod", "other"]),
            ),
        }
    }
}

fn part_label(part: &Part, case: usize) -> usize {
    part.cases
        .iter()
        .position(|own| *own == case)
        .map_or(0, |place| part.labels[place])
}

fn few(labels: &[usize], names: &[&str]) -> String {
    let count = |(class, name): (usize, &&str)| {
        format!(
            "{} {name}",
            labels.iter().filter(|label| **label == class).count()
        )
    };
    format!(
        "minima: {}",
        names
            .iter()
            .enumerate()
            .map(count)
            .collect::<Vec<_>>()
            .join(", ")
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use landscape::agreement::PairMatrix;
    use landscape::evaluation::taxonomy::Candidate;

    /// Minima of these types, about 0.6 apart within a category and `between` apart across categories.
    fn planted(types: &[u8], between: f64) -> Basins {
        let taxonomy = Taxonomy::feix();
        let category = |number: u8| taxonomy.numbered(number).unwrap().category as usize;
        let height = |i: usize, j: usize| {
            let within = category(types[i]) == category(types[j]);
            // The heights differ slightly, so that ranks are not tied.
            (if within { 0.6 } else { between }) + 1e-3 * ((7 * i + 13 * j) % 17) as f64
        };
        let heights = PairMatrix::from_fn(types.len(), height);
        let minimum = |number: &u8| Basin {
            grasps: 1.0,
            grasp_type: Some(*number),
            category: Some(category(*number)),
            cell: None,
            unfiltered: Some(category(*number)),
            best: vec![Candidate {
                number: *number,
                score: 0.95,
            }],
            fit: 0.95,
        };
        Basins {
            name: "planted".to_owned(),
            minima: types.iter().map(minimum).collect(),
            inapplicable: None,
            labelled_in_file: 0,
            group_barrier: 0.1,
            groups: types.len(),
            saddles: heights.clone(),
            barriers: heights.clone(),
            energy_gaps: PairMatrix::from_fn(types.len(), |i, j| ((3 * i + j) % 5) as f64),
            contact_distances: heights.clone(),
            pose_distances: heights,
        }
    }

    fn verdicts(basins: &Basins) -> Vec<(&'static str, Verdict)> {
        let mut settings = ClaimSettings::standard();
        settings.statistics.permutations = 199;
        settings.statistics.bootstrap_draws = 50;
        settings.statistics.label_draws = 5;
        let found = examine(basins, &settings, Rule::standard(), 3);
        found
            .into_iter()
            .map(|finding| (finding.id, finding.verdict))
            .collect()
    }

    fn verdict(basins: &Basins, id: &str) -> Verdict {
        let found = verdicts(basins);
        found.into_iter().find(|(own, _)| *own == id).unwrap().1
    }

    /// Ten power grasps (medium wrap) and ten precision grasps (tripod).
    fn two_kinds() -> Vec<u8> {
        [vec![3; 10], vec![14; 10]].concat()
    }

    #[test]
    fn planted_categories_are_apart_and_mixed_ones_are_not() {
        let apart = planted(&two_kinds(), 2.0);
        assert_eq!(verdict(&apart, "H3"), Verdict::Holds);
        assert_eq!(verdict(&apart, "H1"), Verdict::Holds);
        let mixed = planted(&two_kinds(), 0.6);
        assert_eq!(verdict(&mixed, "H3"), Verdict::Fails);
    }

    #[test]
    fn small_classes_are_insufficient_and_not_failures() {
        let few = planted(&[3, 3, 3, 14, 14], 2.0);
        for id in ["H3", "H4", "H6", "H8"] {
            assert_eq!(verdict(&few, id), Verdict::Insufficient, "{id}");
        }
    }

    #[test]
    fn categories_and_unlisted_grasps_are_counted() {
        let two = planted(&two_kinds(), 2.0);
        assert_eq!(verdict(&two, "H2"), Verdict::Fails, "no intermediate grasp");
        let three = planted(&[two_kinds(), vec![16; 5]].concat(), 2.0);
        assert_eq!(verdict(&three, "H2"), Verdict::Holds);
        assert_eq!(verdict(&three, "H5"), Verdict::Fails, "all are listed");
        let mut some = three;
        for minimum in &mut some.minima[..4] {
            minimum.fit = 0.05;
        }
        assert_eq!(verdict(&some, "H5"), Verdict::Holds);
    }

    #[test]
    fn spheres_near_tripods_are_seen() {
        let types = [vec![13; 6], vec![14; 6], vec![3; 6]].concat();
        let near = planted(&types, 2.0);
        assert_eq!(verdict(&near, "H8"), Verdict::Holds);
        let far = planted(&types, 0.6);
        assert_eq!(verdict(&far, "H8"), Verdict::Fails);
    }
}
