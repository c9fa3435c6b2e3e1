//! How well each type fits the facts, and what follows for category, cell and type.

use super::anatomy::Anatomy;
use super::facts::Facts;
use super::form::Held;
use super::label::{Candidate, Verdict};
use super::rule::{Cue, Rule, Sharpness, meaning, name};
use super::table::{Category, GraspType, Taxonomy};
use super::touch::ramp;

/// Factor by which a size outside its range loses its whole value.
const SIZE_FACTOR: f64 = 2.0;
/// Share of the pose as it is, where it has other readings.
const AS_POSED: f64 = 0.5;
/// Number of types in an answer, and of facts that an explanation lists.
const TYPES: usize = 3;
const LISTED: usize = 5;
/// Facts that change the fit by less than this factor are left out of explanations.
const TOLD: f64 = 0.9;

/// A fact that a type expects.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Evidence {
    /// Name of the fact.
    pub fact: &'static str,
    /// Meaning of the fact.
    pub meaning: &'static str,
    /// Measured value, 0 to 1.
    pub value: f64,
    /// Whether the type expects it to be present or absent.
    pub present: bool,
    /// Factor of the type's fit.
    pub factor: f64,
}

/// How well each type fits, by number; `None` for types that the hand cannot do.
///
/// ```text
/// fit = Π over what the type expects of (1 − t + t x),   x: the fact, or 1 − the fact where it should be absent
/// ```
///
/// `t`: trust in the fact, see `data/taxonomy/rule.toml`. The factors are those of independent observations, so the fits of
/// all types divided by their sum would be probabilities under equal odds if the facts were independent. They are not, so
/// probabilities are made of the fits to the power that [`Rule::sharpness`] gives.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Fits(Vec<Option<f64>>);

impl Fits {
    pub(super) fn of(rule: &Rule, anatomy: &Anatomy, facts: &Facts, held: Option<&Held>) -> Self {
        let types = Taxonomy::feix().types.iter();
        let fit_of = |entry: &GraspType| {
            let can = rule.can_be_done(anatomy, entry);
            can.then(|| fit(rule, entry, facts, held))
        };
        Self(types.map(fit_of).collect())
    }

    /// The largest fit.
    pub(super) fn best(&self) -> f64 {
        self.0.iter().flatten().copied().fold(0.0, f64::max)
    }

    /// Probabilities of the types by number.
    fn probabilities(&self, exponent: f64) -> Vec<f64> {
        let blunted = |fit: f64| libm::pow(fit, exponent);
        let sum: f64 = self.0.iter().flatten().copied().map(blunted).sum();
        let share =
            |fit: &Option<f64>| fit.map_or(0.0, |fit| blunted(fit) / sum.max(f64::MIN_POSITIVE));
        self.0.iter().map(share).collect()
    }
}

/// How well a type fits, 0 to 1.
pub(super) fn fit(rule: &Rule, entry: &GraspType, facts: &Facts, held: Option<&Held>) -> f64 {
    let cues = rule.cues(entry).iter();
    let factors = cues.filter_map(|cue| {
        let value = value(cue, entry, facts, held)?;
        Some(factor(cue, value))
    });
    factors.product()
}

/// What follows from the fits: category, cell and type, in this order.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Answer {
    pub(super) fit: f64,
    pub(super) categories: Vec<(Category, f64)>,
    pub(super) category: Option<Category>,
    pub(super) cell_probability: f64,
    pub(super) best: Vec<Candidate>,
    pub(super) types: Vec<Candidate>,
    /// Share of the best cell in its category, and of the best type in its cell.
    shares: [f64; 2],
}

impl Answer {
    /// The answer for a pose and its corrected readings; `None` without any fits.
    ///
    /// The order of the answers follows from the fits as they are, and so does what is close. The probabilities that are
    /// told are made of the fits to the power that `sharpness` gives, and then made to agree with the answer ([`agree`]).
    pub(super) fn of(
        posed: Option<&Fits>,
        corrected: &[&Fits],
        sharpness: Sharpness,
    ) -> Option<Self> {
        let all = || posed.into_iter().chain(corrected.iter().copied());
        let fit = all().map(Fits::best).reduce(f64::max)?;
        let [plain, mut told] =
            [1.0, sharpness.exponent(fit)].map(|power| probabilities(posed, corrected, power));
        let place = |entry: &GraspType| usize::from(entry.number) - 1;
        let of = |entry: &GraspType| plain[place(entry)];
        let types = || Taxonomy::feix().types.iter();
        let sum = |of: &[f64], test: &dyn Fn(&GraspType) -> bool| -> f64 {
            let own = types().filter(|entry| test(entry));
            own.map(|entry| of[place(entry)]).sum()
        };
        let categories = |of: &[f64]| {
            [Category::Power, Category::Precision, Category::Intermediate]
                .map(|category| (category, sum(of, &|entry| entry.category == category)))
        };
        let most = (categories(&plain).into_iter().rev()).max_by(|a, b| a.1.total_cmp(&b.1));
        let category = most.map(|(category, _)| category);
        let mut ranked: Vec<&GraspType> = types().filter(|entry| of(entry) > 0.0).collect();
        ranked.sort_by(|a, b| of(b).total_cmp(&of(a)).then(a.number.cmp(&b.number)));
        // The answer stands first: the best type of the most probable category.
        if let Some(place) = ranked
            .iter()
            .position(|entry| Some(entry.category) == category)
        {
            ranked[..=place].rotate_right(1);
        }
        if let Some(answer) = ranked.first() {
            agree(&mut told, answer, &categories(&plain));
        }
        let cell = ranked.first().map_or("", |entry| entry.cell.as_str());
        let candidate = |entry: &GraspType| Candidate {
            number: entry.number,
            score: told[place(entry)],
        };
        let of_cell = sum(&plain, &|entry| entry.cell == cell);
        Some(Self {
            fit,
            cell_probability: sum(&told, &|entry| entry.cell == cell),
            shares: [
                of_cell / most.map_or(1.0, |(_, p)| p),
                ranked.first().map_or(0.0, |entry| of(entry)) / of_cell,
            ],
            best: ranked
                .iter()
                .take(TYPES)
                .map(|entry| candidate(entry))
                .collect(),
            types: types().map(candidate).collect(),
            category,
            categories: categories(&told).to_vec(),
        })
    }

    /// The label: as precise as the probabilities allow.
    pub(super) fn verdict(&self, rule: &Rule) -> Verdict {
        let Some(first) = self.best.first() else {
            return Verdict::Unlisted;
        };
        match () {
            () if self.fit < rule.unlisted_below => Verdict::Unlisted,
            () if self.shares[0] < rule.cell_share => Verdict::Broad(first.number),
            () if self.shares[1] < rule.type_share => Verdict::Ambiguous(first.number),
            () => Verdict::Listed(first.number),
        }
    }
}

/// Makes the probabilities of the types agree with the answer where a power of the fits has changed their order: those of the
/// categories are given out in the order of `categories`, which decided, and in its category the answer has the greatest.
fn agree(told: &mut [f64], answer: &GraspType, categories: &[(Category, f64)]) {
    let types = &Taxonomy::feix().types;
    let place = |entry: &GraspType| usize::from(entry.number) - 1;
    let of = |category: Category| types.iter().filter(move |entry| entry.category == category);
    let mut order: Vec<&(Category, f64)> = categories.iter().collect();
    order.sort_by(|a, b| b.1.total_cmp(&a.1));
    // Of categories that are equally probable, that of the answer is the first.
    order.sort_by_key(|(category, _)| *category != answer.category);
    let shares: Vec<f64> = (order.iter())
        .map(|(category, _)| of(*category).map(|entry| told[place(entry)]).sum())
        .collect();
    let mut given = shares.clone();
    given.sort_by(|a, b| b.total_cmp(a));
    for ((category, _), (share, given)) in order.into_iter().zip(shares.into_iter().zip(given)) {
        // A category without any probability has no types to give it to.
        if share > 0.0 && share.to_bits() != given.to_bits() {
            for entry in of(*category) {
                told[place(entry)] *= given / share;
            }
        }
    }
    let own = of(answer.category).map(place);
    if let Some(most) = own.max_by(|a, b| told[*a].total_cmp(&told[*b])) {
        told.swap(most, place(answer));
    }
}

fn probabilities(posed: Option<&Fits>, corrected: &[&Fits], exponent: f64) -> Vec<f64> {
    let mut sum = vec![0.0; Taxonomy::feix().types.len()];
    let mut add = |fits: &Fits, weight: f64| {
        for (sum, p) in sum.iter_mut().zip(fits.probabilities(exponent)) {
            *sum += weight * p;
        }
    };
    let own = match (posed, corrected) {
        (None, _) => 0.0,
        (_, []) => 1.0,
        _ => AS_POSED,
    };
    if let Some(fits) = posed {
        add(fits, own);
    }
    for fits in corrected {
        add(fits, (1.0 - own) / corrected.len() as f64);
    }
    sum
}

/// The value of the fact that a cue is about; form and size are compared with those that the type usually holds.
fn value(cue: &Cue, entry: &GraspType, facts: &Facts, held: Option<&Held>) -> Option<f64> {
    match name(cue.fact) {
        "form" => held.map(|held| {
            let degrees = entry.forms.iter().map(|form| held.degree(*form));
            degrees.sum::<f64>().min(1.0)
        }),
        "size" => {
            let ([low, high], held) = (entry.size_mm?, held?);
            let size = 1e3 * held.size_m(&entry.forms).max(1e-6);
            let miss = (low / size).max(size / high).max(1.0);
            Some(1.0 - ramp(libm::log(miss), 0.0, libm::log(SIZE_FACTOR)))
        }
        _ => match cue.or.and_then(|other| facts.value(other)) {
            Some(other) => Some(facts.value(cue.fact).unwrap_or(0.0).max(other)),
            None => facts.value(cue.fact),
        },
    }
}

fn factor(cue: &Cue, value: f64) -> f64 {
    let found = if cue.present { value } else { 1.0 - value };
    1.0 - cue.trust + cue.trust * found
}

/// What a type expects and finds, or does not find; most important first.
pub(super) fn evidence(
    rule: &Rule,
    entry: &GraspType,
    facts: &Facts,
    held: Option<&Held>,
    found: bool,
) -> Vec<Evidence> {
    let told = rule.cues(entry).iter().filter_map(|cue| {
        let value = value(cue, entry, facts, held)?;
        let factor = factor(cue, value);
        ((factor >= TOLD) == found).then_some((
            cue.trust,
            Evidence {
                fact: name(cue.fact),
                meaning: meaning(cue.fact),
                value,
                present: cue.present,
                factor,
            },
        ))
    });
    let mut told: Vec<(f64, Evidence)> = told.collect();
    if found {
        // What must be present tells more than what must be absent.
        let weight =
            |(trust, evidence): &(f64, Evidence)| trust + f64::from(u8::from(evidence.present));
        told.sort_by(|a, b| weight(b).total_cmp(&weight(a)));
    } else {
        told.sort_by(|a, b| a.1.factor.total_cmp(&b.1.factor));
    }
    told.truncate(LISTED);
    told.into_iter().map(|(_, evidence)| evidence).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const AS_THEY_ARE: Sharpness = Sharpness {
        least: 1.0,
        by_fit: 0.0,
    };

    fn answer(fits: &[(u8, f64)]) -> Answer {
        let of = |number: u8| fits.iter().find(|(known, _)| *known == number);
        let fits = (1..=33).map(|number| Some(of(number).map_or(1e-4, |(_, fit)| *fit)));
        Answer::of(Some(&Fits(fits.collect())), &[], AS_THEY_ARE).unwrap()
    }

    /// 1 and 3 are of one cell, 31 of another cell of their category, 14 of another category.
    #[test]
    fn the_label_is_as_precise_as_the_probabilities() {
        let rule = Rule::standard();
        let verdict = |fits: &[(u8, f64)]| answer(fits).verdict(rule);
        assert_eq!(verdict(&[(3, 0.9), (1, 0.1)]), Verdict::Listed(3));
        assert_eq!(
            verdict(&[(3, 0.6), (1, 0.5), (2, 0.5), (14, 0.3)]),
            Verdict::Ambiguous(3)
        );
        assert_eq!(
            verdict(&[(3, 0.6), (31, 0.55), (28, 0.55)]),
            Verdict::Broad(3)
        );
        let low = 0.9 * rule.unlisted_below;
        assert_eq!(verdict(&[(3, low)]), Verdict::Unlisted);
    }

    #[test]
    fn the_type_is_of_the_most_probable_category() {
        // Tripod fits best of all, but power grasps together are more probable.
        let found = answer(&[(14, 0.8), (3, 0.7), (1, 0.6)]);
        assert_eq!(found.category, Some(Category::Power));
        let numbers: Vec<u8> = found.best.iter().map(|best| best.number).collect();
        assert_eq!(numbers, [3, 14, 1]);
        let sum: f64 = found.categories.iter().map(|(_, p)| p).sum();
        assert!((sum - 1.0).abs() < 1e-9, "{sum}");
        // Every type has a probability, and the best ones are among them.
        let all: f64 = found.types.iter().map(|kind| kind.score).sum();
        assert!((all - 1.0).abs() < 1e-9, "{all}");
        let own = |best: &Candidate| found.types[usize::from(best.number) - 1] == *best;
        assert!(found.types.len() == 33 && found.best.iter().all(own));
    }

    /// How certain the probabilities are does not change the answer; a grasp that fits a type well is named with more
    /// certainty, and one that fits all badly with less.
    #[test]
    fn certainty_follows_the_fit() {
        let by_fit = Sharpness {
            least: 0.6,
            by_fit: 1.5,
        };
        for (best, next) in [(0.9, 0.45), (0.1, 0.05)] {
            let fits = (1..=33).map(|number| match number {
                3 => Some(best),
                1 => Some(next),
                _ => None,
            });
            let fits = Fits(fits.collect());
            let [plain, told] = [AS_THEY_ARE, by_fit]
                .map(|sharpness| Answer::of(Some(&fits), &[], sharpness).unwrap());
            let rule = Rule::standard();
            assert_eq!(plain.verdict(rule), told.verdict(rule));
            let numbers = |answer: &Answer| {
                let best = answer.best.iter();
                best.map(|best| best.number).collect::<Vec<u8>>()
            };
            assert_eq!(numbers(&plain), numbers(&told));
            // The second type is half as likely as the first, to the power of the exponent.
            let other = libm::pow(0.5, 0.6 + 1.5 * best);
            assert!((plain.best[0].score - 2.0 / 3.0).abs() < 1e-12);
            assert!((told.best[0].score - 1.0 / (1.0 + other)).abs() < 1e-12);
            assert!((told.best[0].score > plain.best[0].score) == (best > 0.5));
        }
    }

    /// A power of the fits favours one good type over several fair ones, and may so change the order of categories and of
    /// types. What is told must not contradict the answer.
    #[test]
    fn what_is_told_agrees_with_the_answer() {
        let steep = Sharpness {
            least: 3.0,
            by_fit: 0.0,
        };
        let fits = |some: &[(u8, f64)]| {
            let of = |number: u8| some.iter().find(|(known, _)| *known == number);
            Fits(
                (1..=33)
                    .map(|number| of(number).map(|(_, fit)| *fit))
                    .collect(),
            )
        };
        // Three fair power grasps together are more probable than one tripod, until they are raised to a power.
        let several = fits(&[(3, 0.2), (1, 0.21), (2, 0.2), (14, 0.4)]);
        // One reading is sure of 3, the other prefers 1 a little.
        let [sure, unsure] = [&[(3, 0.9), (1, 0.1)], &[(3, 0.3), (1, 0.7)]].map(|some| fits(some));
        for (posed, corrected) in [(&several, vec![]), (&sure, vec![&unsure])] {
            let found = Answer::of(Some(posed), &corrected, steep).unwrap();
            let plain = Answer::of(Some(posed), &corrected, AS_THEY_ARE).unwrap();
            let answer = found.best[0];
            assert_eq!(answer.number, plain.best[0].number);
            assert_eq!(found.category, plain.category);
            let most = found.categories.iter().max_by(|a, b| a.1.total_cmp(&b.1));
            assert_eq!(most.map(|(category, _)| *category), found.category);
            let own = Taxonomy::feix().types.iter();
            let mut own = own.filter(|entry| Some(entry.category) == found.category);
            assert!(
                own.all(|entry| {
                    found.types[usize::from(entry.number) - 1].score <= answer.score
                })
            );
            let sum: f64 = found.types.iter().map(|kind| kind.score).sum();
            assert!((sum - 1.0).abs() < 1e-12, "{sum}");
        }
    }

    /// A fact that must be present and is absent leaves a type a twentieth of its fit.
    #[test]
    fn what_is_absent_cannot_win() {
        let rule = Rule::standard();
        for entry in &Taxonomy::feix().types {
            let opposition = format!("{} opposition", entry.opposition.name());
            let cues = rule.cues(entry).iter();
            let own = cues.filter(|cue| name(cue.fact) == opposition);
            let lost: Vec<f64> = own.map(|cue| factor(cue, 0.0)).collect();
            assert!(
                lost.len() == 1 && lost[0] < 0.06,
                "{}: {lost:?}",
                entry.name
            );
        }
    }
}
