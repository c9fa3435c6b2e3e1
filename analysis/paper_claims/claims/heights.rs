//! Claims H1 to H6 and H8, which need only heights and labels.

use super::{Claims, Finding, Verdict};
use landscape::agreement::{
    Correlation, Dendrogram, Permutations, Tested, anosim_of_ranks, barrier_ratio, bootstrap,
    cliffs_delta, indicator, mantel, morans_i, partial_mantel, test_labels, test_uncertain_labels,
};
use landscape::evaluation::taxonomy::{Category, Rule, Taxonomy};
use landscape::study::{Basin, Basins, Part, StatisticsSettings};

const POWER: usize = Category::Power as usize;
const INTERMEDIATE: usize = Category::Intermediate as usize;
const PRECISION: usize = Category::Precision as usize;

pub(super) fn examine(basins: &Basins, claims: &Claims, rule: &Rule, seed: u64) -> Vec<Finding> {
    let asked = Asked {
        basins,
        claims,
        settings: &claims.statistics,
        permutations: claims.statistics.permutations(seed),
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
    claims: &'a Claims,
    settings: &'a StatisticsSettings,
    permutations: Permutations,
    seed: u64,
}

impl Asked<'_> {
    fn test(&self, part: &Part, statistic: impl Fn(&[usize]) -> f64 + Sync) -> Option<Tested> {
        test_labels(&part.labels, &part.blocks, &self.permutations, statistic).known()
    }

    /// The verdict, where the hand has the regions of a human one.
    fn verdict(&self, holds: bool) -> Verdict {
        if self.basins.inapplicable.is_none() {
            Verdict::of(holds)
        } else {
            Verdict::Insufficient
        }
    }

    /// The share of the grasps that lie in these minima, and the number of these minima.
    fn share(&self, of: impl Fn(&Basin) -> bool) -> (f64, usize) {
        // Starts from 0, since an empty sum is −0.
        let grasps = |of: &dyn Fn(&Basin) -> bool| {
            let own = self.basins.minima.iter().filter(|basin| of(basin));
            own.fold((0.0, 0), |(sum, count), basin| {
                (sum + basin.grasps, count + 1)
            })
        };
        let (own, minima) = grasps(&of);
        (own / grasps(&|_| true).0, minima)
    }

    fn alike(&self) -> Finding {
        let asked = self.claims.get("H1");
        let heights = self.basins.saddles.raised(self.settings.censored_factor);
        let blocks = vec![0; self.basins.minima.len()];
        if self.basins.inapplicable.is_some() || blocks.len() < self.settings.least_per_class {
            let why = "too few minima, or a hand without the regions of a human one";
            return asked.insufficient(why);
        }
        let Basins {
            contact_distances,
            pose_distances,
            energy_gaps,
            ..
        } = self.basins;
        let (spearman, permutations) = (Correlation::Spearman, &self.permutations);
        let contacts = mantel(&heights, contact_distances, spearman, &blocks, permutations);
        let gaps = partial_mantel(
            &heights,
            contact_distances,
            energy_gaps,
            spearman,
            &blocks,
            permutations,
        );
        let pose = mantel(&heights, pose_distances, spearman, &blocks, permutations);
        let strong = contacts.statistic >= asked.number("least_correlation");
        asked.finding(
            Verdict::of(strong && contacts.p < asked.number("level")),
            Some(contacts.p),
            format!(
                "Mantel's rank correlation of saddle heights with distances of contact areas {:.3} (p {:.4}), given the \
                 gap in energy {:.3} (p {:.4}); control: with distances of poses {:.3} (p {:.4})",
                contacts.statistic, contacts.p, gaps.statistic, gaps.p, pose.statistic, pose.p
            ),
        )
    }

    fn all(&self) -> Finding {
        let asked = self.claims.get("H2");
        let mut holds = true;
        let mut parts = Vec::new();
        for category in [Category::Power, Category::Intermediate, Category::Precision] {
            let (share, minima) = self.share(|basin| basin.unfiltered == Some(category as usize));
            holds &= share >= asked.number("least_share");
            holds &= minima as f64 >= asked.number("least_minima");
            let (name, percent) = (category.name(), 100.0 * share);
            parts.push(format!("{name} {percent:.1} % ({minima} minima)"));
        }
        let parts = parts.join(", ");
        let measured = format!("of the grasps, by the type that fits best: {parts}");
        asked.finding(self.verdict(holds), None, measured)
    }

    fn apart(&self) -> Finding {
        let asked = self.claims.get("H3");
        let part = Part::new(self.basins, self.settings, |basin| match basin.category {
            Some(POWER) => Some(0),
            Some(PRECISION) => Some(1),
            _ => None,
        });
        let ratio = barrier_ratio(&part.barriers, &part.labels, [0, 1]);
        let ranks = part.saddles.ranks();
        let tree = Dendrogram::new(&part.saddles);
        let anosim = self.test(&part, |labels| anosim_of_ranks(&ranks, labels));
        let purity = self.test(&part, |labels| tree.purity(labels, &part.weights));
        let (Some(anosim), Some(purity)) = (anosim, purity) else {
            return asked.insufficient(&few(&part.labels, &["power", "precision"]));
        };
        let quick = Permutations {
            count: self.settings.label_permutations,
            ..self.permutations
        };
        let cases = part.cases.iter().zip(&part.labels);
        let weights: Vec<Vec<f64>> = cases.map(|(&i, &label)| self.drawn(i, label)).collect();
        let unsure = test_uncertain_labels(
            &weights,
            &part.blocks,
            self.settings.label_draws,
            &quick,
            |labels| anosim_of_ranks(&ranks, labels),
        );
        let [low, high] = unsure.statistic.interval(0.95);
        let holds = ratio.ratio >= asked.number("least_ratio")
            && anosim.statistic >= asked.number("least_anosim")
            && anosim.p < asked.number("level")
            && purity.p < asked.number("purity_level");
        asked.finding(
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
        let best = &self.basins.minima[case].best;
        let first = best.first().map_or(0.0, |first| first.score);
        let mut weights = vec![0.0; 2];
        for candidate in best {
            let entry = Taxonomy::feix().numbered(candidate.number);
            let weight = libm::exp((candidate.score - first) / self.settings.label_temperature);
            match entry.map(|entry| entry.category as usize) {
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
        let asked = self.claims.get("H4");
        let part = Part::new(self.basins, self.settings, |basin| basin.category);
        let graph = part.graph(self.basins.family_barrier);
        let of_class = part.labels.iter().filter(|label| **label == INTERMEDIATE);
        let count = of_class.count();
        if count < self.settings.least_per_class {
            return asked.insufficient(&format!("{count} intermediate minima"));
        }
        let draws = self.settings.bootstrap_draws;
        let [power, own, precision] = [POWER, INTERMEDIATE, PRECISION].map(|class| {
            let drawn = bootstrap(&part.blocks, draws, self.seed, |cases| {
                let labels: Vec<usize> = cases.iter().map(|&i| part.labels[i]).collect();
                morans_i(&graph.chosen(cases, 0.0), &indicator(&labels, class))
            });
            drawn.interval(0.95)
        });
        let labels = part.labels.iter();
        let two: Vec<usize> = labels
            .map(|label| usize::from(*label == INTERMEDIATE))
            .collect();
        let tested = test_labels(&two, &part.blocks, &self.permutations, |labels| {
            morans_i(&graph, &indicator(labels, 1))
        });
        let p = tested.known().map(|tested| tested.p);
        let below = own[1] < power[0] && own[1] < precision[0];
        let chance = p.is_some_and(|p| p > asked.number("level"))
            && count as f64 >= asked.number("least_minima");
        asked.finding(
            Verdict::of(below || chance),
            p,
            format!(
                "Moran's I of intermediate {:.3} to {:.3}, of power {:.3} to {:.3}, of precision {:.3} to {:.3} (95 %)",
                own[0], own[1], power[0], power[1], precision[0], precision[1]
            ),
        )
    }

    fn unlisted(&self, rule: &Rule) -> Finding {
        let asked = self.claims.get("H5");
        let share = |threshold: f64| self.share(|basin| basin.fit < threshold).0;
        let here = share(rule.unlisted_below);
        let thresholds = asked.pair("other_thresholds");
        let others = thresholds.map(share);
        let [least, most] = asked.pair("share");
        let holds = (least..=most).contains(&here) && others.iter().all(|share| *share > 0.0);
        asked.finding(
            self.verdict(holds),
            None,
            format!(
                "{:.1} % of the grasps fit no type better than {}; {:.1} % below {}, {:.1} % below {} (a person has not looked at them)",
                100.0 * here,
                rule.unlisted_below,
                100.0 * others[0],
                thresholds[0],
                100.0 * others[1],
                thresholds[1]
            ),
        )
    }

    fn nearest(&self) -> Finding {
        let asked = self.claims.get("H6");
        let precision = self.basins.cases(|basin| basin.category == Some(PRECISION));
        let part = Part::new(self.basins, self.settings, |basin| {
            let number = basin.grasp_type;
            let sphere = asked.has("spheres", number);
            (sphere || asked.has("others", number)).then_some(usize::from(sphere))
        });
        let raised = self.basins.barriers.raised(self.settings.censored_factor);
        let least = |&i: &usize| {
            let others = precision.iter().filter(|j| **j != i);
            others
                .map(|&j| raised.get(i, j))
                .fold(f64::INFINITY, f64::min)
        };
        let least: Vec<f64> = part.cases.iter().map(least).collect();
        let delta = |labels: &[usize]| {
            let of = |class: usize| -> Vec<f64> {
                let own = least
                    .iter()
                    .zip(labels)
                    .filter(|(_, label)| **label == class);
                own.map(|(barrier, _)| *barrier).collect()
            };
            cliffs_delta(&of(1), &of(0))
        };
        let tested = self.test(&part, |labels| -delta(labels));
        let Some(tested) = tested.filter(|_| precision.len() >= self.settings.least_per_class)
        else {
            return asked.insufficient(&format!(
                "{}; {} precision minima",
                few(&part.labels, &["cylinder or disk", "sphere"]),
                precision.len()
            ));
        };
        let (delta, p) = (-tested.statistic, tested.p);
        asked.finding(
            Verdict::of(delta <= asked.number("most_delta") && p < asked.number("level")),
            Some(p),
            format!(
                "Cliff's delta of the least barrier to a precision grasp, spheres over cylinders and disks: {delta:.2} (p {p:.4})"
            ),
        )
    }

    fn tripods(&self) -> Finding {
        let asked = self.claims.get("H8");
        let part = Part::new(self.basins, self.settings, |basin| {
            let number = Some(basin.grasp_type?);
            Some(match () {
                () if asked.has("spheres", number) => 0,
                () if asked.has("near", number) => 1,
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
        let tested = self.test(&part, |labels| -ratio(labels));
        let both = part.labels.contains(&1) && part.labels.contains(&0);
        let Some(tested) = tested.filter(|_| both) else {
            let classes = ["sphere", "tripod or quadpod", "other"];
            return asked.insufficient(&few(&part.labels, &classes));
        };
        let (ratio, p) = (-tested.statistic, tested.p);
        asked.finding(
            Verdict::of(ratio <= asked.number("most_ratio") && p < asked.number("level")),
            Some(p),
            format!(
                "mean barrier from spheres to tripods and quadpods over that to all other types {ratio:.2} (p {p:.4})"
            ),
        )
    }
}

/// The number of minima of each class.
fn few(labels: &[usize], names: &[&str]) -> String {
    let count = |(class, name): (usize, &&str)| {
        let own = labels.iter().filter(|label| **label == class);
        format!("{} {name}", own.count())
    };
    let counts: Vec<String> = names.iter().enumerate().map(count).collect();
    format!("minima: {}", counts.join(", "))
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
            family_barrier: 0.1,
            families: types.len(),
            saddles: heights.clone(),
            barriers: heights.clone(),
            energy_gaps: PairMatrix::from_fn(types.len(), |i, j| ((3 * i + j) % 5) as f64),
            contact_distances: heights.clone(),
            pose_distances: heights,
        }
    }

    fn verdicts(basins: &Basins) -> Vec<(String, Verdict)> {
        let mut settings = Claims::standard();
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
        found.into_iter().find(|(own, _)| own == id).unwrap().1
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
