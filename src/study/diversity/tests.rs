//! Planted populations: what is known of them must be found, and nothing else.

use rand::distr::Distribution;
use rand::distr::weighted::WeightedIndex;

use super::*;
use crate::sample::{Task, stream};

fn set(name: &str, of: Counted, counts: &[usize]) -> DiversitySet {
    let named = counts.iter().enumerate();
    let named = named.map(|(kind, count)| (format!("{kind:03}"), *count));
    DiversitySet::counted(name, of, named.collect())
}

/// A set of `grasps` grasps drawn from kinds with these shares.
fn drawn(name: &str, shares: &[f64], grasps: usize, id: u64) -> DiversitySet {
    let kinds = WeightedIndex::new(shares).unwrap();
    let mut rng = stream(11, Task::Start, id);
    let mut counts = vec![0; shares.len()];
    (0..grasps).for_each(|_| counts[kinds.sample(&mut rng)] += 1);
    set(name, Counted::Families, &counts)
}

fn compare(sets: &[DiversitySet]) -> DiversityComparison {
    compare_diversity(sets, &DiversitySettings::default()).unwrap()
}

#[test]
fn equal_families_have_their_number_in_every_order() {
    let found = compare(&[set("a", Counted::Families, &[8; 9])]);
    for number in found.measures[0].sets[0].unwrap() {
        assert!((number.value - 9.0).abs() < 1e-9, "{number:?}");
    }
    assert_eq!(found.answer(), "a has 9.0 effective families (order 1).");
}

#[test]
fn sets_are_compared_at_the_size_of_the_smallest() {
    let shares = [1.0; 30];
    let [large, small] = [("large", 2000, 1), ("small", 60, 2)]
        .map(|(name, grasps, id)| drawn(name, &shares, grasps, id));
    let found = compare(&[large.clone(), small]);
    assert_eq!(found.measures[0].grasps, 60);
    // Sixty draws from thirty equal families meet 30 (1 − (29/30)⁶⁰) of them.
    let expected = 30.0 * (1.0 - (29.0_f64 / 30.0).powi(60));
    let large_at_sixty = found.measures[0].sets[0].unwrap()[0];
    assert!(
        (large_at_sixty.value - expected).abs() < 0.1,
        "{large_at_sixty:?}"
    );
    let answer = found.answer();
    assert!(
        answer.starts_with("These grasps show no difference in families: "),
        "{answer}"
    );
    let own_size = compare(&[large]).measures[0].sets[0].unwrap()[0];
    assert!((own_size.value - 30.0).abs() < 1e-9, "{own_size:?}");
}

/// The same source is seldom called different, and a more diverse source nearly always is.
#[test]
fn the_more_diverse_source_is_found_and_no_other() {
    let narrow: Vec<f64> = (1..=20).map(|rank| f64::from(rank).powi(-2)).collect();
    let wide = [1.0; 20];
    let (mut right, mut wrong) = (0, 0);
    for id in 0..40 {
        let settings = DiversitySettings {
            resamplings: 60,
            seed: id,
        };
        let most =
            |sets: &[DiversitySet]| compare_diversity(sets, &settings).unwrap().measures[0].most;
        let [a, b] =
            [("a", 3 * id), ("b", 3 * id + 1)].map(|(name, id)| drawn(name, &narrow, 100, id));
        wrong += usize::from(most(&[a.clone(), b])[1].is_some());
        right += usize::from(most(&[a, drawn("c", &wide, 80, 3 * id + 2)]) == [Some(1); 3]);
    }
    assert!(
        right == 40 && wrong <= 2,
        "{right} right, {wrong} wrong of 40"
    );
}

#[test]
fn the_most_diverse_of_several_is_above_all_others() {
    let of = Counted::Families;
    let mut sets = vec![
        set("a", of, &[50, 50]),
        set("b", of, &[10; 10]),
        set("c", of, &[5; 20]),
    ];
    let told = compare(&sets).answer();
    let expected = "c is the most diverse by families: it has 2.0 times as many effective families as b, the next (order 1, 95 % \
                    interval 1.";
    assert!(told.starts_with(expected), "{told}");
    sets.push(set("d", of, &[5; 20]));
    let told = compare(&sets).answer();
    let expected = "These grasps do not show which set is the most diverse by families: c has 1.0 times as many effective \
                    families as d, the next (order 1";
    assert!(told.starts_with(expected), "{told}");
}

/// The answer says by how much, how sure this is, and how many grasps would show it.
#[test]
fn a_difference_that_does_not_show_is_told_with_its_size() {
    let of = Counted::Contacts;
    let sets = [
        set("human", of, &[9, 6, 4, 3, 2, 2, 1, 1, 1, 1]),
        set("shadow", of, &[6, 5, 4, 4, 3, 3, 2, 2, 1, 1, 1, 1]),
    ];
    let found = compare(&sets);
    let ratio = found.measures[0].ratio([1, 0]).unwrap()[1];
    assert!(ratio.value > 1.1 && !ratio.differs(), "{ratio:?}");
    let needed = ratio.members_needed.unwrap();
    let answer = found.answer();
    for expected in [
        "These grasps show no difference in sets of contact regions: shadow has 1.",
        " times as many effective sets of contact regions as human (order 1, 95 % interval 0.",
        " grasps in each set would show a difference of this size in four of five comparisons.",
        "does not mean that the sets are equal",
    ] {
        assert!(answer.contains(expected), "{answer}");
    }
    let told = answer
        .split("; about ")
        .nth(1)
        .unwrap()
        .split(' ')
        .next()
        .unwrap();
    let told: usize = told.parse().unwrap();
    assert!(
        (needed..needed + needed / 5).contains(&told),
        "{told} {needed}"
    );
    let sentence = found.sentence().unwrap();
    for expected in [
        "human n = 30",
        "order 1",
        "500 bootstrap resamplings",
        "samples of 30 grasps",
        "(shadow to human)",
    ] {
        assert!(sentence.contains(expected), "{sentence}");
    }
    assert_eq!(found.to_json()["sentence"], sentence.as_str());
    assert!(found.markdown().contains("For a paper: By Hill numbers"));
}

/// A ratio that is found although the intervals of the two sets overlap.
#[test]
fn overlapping_intervals_may_differ() {
    let of = Counted::Types;
    let one = set("one", of, &[20, 20, 20, 12, 10, 6, 6, 2, 2, 2]);
    let other = set("other", of, &[30, 24, 20, 10, 8, 4, 2, 1, 1]);
    let measure = &compare(&[one, other]).measures[0];
    let [one, other] = [0, 1].map(|set| measure.sets[set].unwrap()[2]);
    assert!(one.interval[0] < other.interval[1], "{one:?} {other:?}");
    assert_eq!(measure.most[2], Some(0), "{:?}", measure.ratios);
}

#[test]
fn limits_of_the_sets_are_told() {
    let told = |hands: [&str; 2]| {
        let sets = hands.map(|hand| {
            let mut set = set(hand, Counted::Types, &[20, 20]);
            set.hands = vec![hand.to_owned()];
            set
        });
        compare(&sets).notes.join("\n")
    };
    let robot = told(["human", "shadow"]);
    assert!(
        robot.contains("types and cells of shadow are by a rule that was made for the human hand"),
        "{robot}"
    );
    assert!(robot.contains("sampler"), "{robot}");
    assert!(!told(["human", "human"]).contains("rule"));
    let single = compare(&[
        set("a", Counted::Types, &[30]),
        set("b", Counted::Types, &[15, 15]),
    ]);
    let notes = single.notes.join("\n");
    assert!(
        notes.contains("all 30 grasps of a are of one kind by types")
            && notes.contains("up to 10 %"),
        "{notes}"
    );
}

#[test]
fn orders_that_disagree_are_not_decided() {
    // Many rare families beside one that holds most, against few equal ones.
    let mut rare = vec![2; 40];
    rare.push(220);
    let found = compare(&[
        set("rare", Counted::Families, &rare),
        set("even", Counted::Families, &[30; 10]),
    ]);
    assert_eq!(found.measures[0].most, [Some(0), Some(1), Some(1)]);
    assert!(
        found.answer().contains("the orders disagree"),
        "{}",
        found.answer()
    );
}

#[test]
fn small_sets_are_refused() {
    let sets = [
        set("few", Counted::Families, &[10, 10, 9]),
        set("many", Counted::Families, &[40]),
    ];
    let refused = compare_diversity(&sets, &DiversitySettings::default()).unwrap_err();
    let text = refused.to_string();
    let expected = "few has 29 grasps (1 too few); at least 30 in each set are needed";
    assert!(
        text.starts_with(expected) && text.contains("synth -n 40"),
        "{text}"
    );
    let all = check_set_sizes([("a", 21), ("b", 40), ("c", 24), ("d", 1)]);
    let text = all.unwrap_err().to_string();
    let expected = "a has 21 grasps (9 too few), c has 24 grasps (6 too few) and d has 1 grasp (29 too few); at least 30";
    assert!(text.starts_with(expected), "{text}");
    // Enough grasps, of which too few have a type.
    let mut typed = set("typed", Counted::Types, &[20, 20]);
    typed.grasps = 40;
    let mut untyped = set("untyped", Counted::Types, &[12]);
    untyped.grasps = 40;
    let found = compare(&[typed, untyped]);
    assert_eq!(found.measures[0].sets.iter().flatten().count(), 1);
    assert_eq!(
        found.answer(),
        "Nothing can be compared: the notes say why."
    );
    let note = "12 of the 40 grasps of untyped have types, but at least 30 are needed";
    assert!(found.notes.contains(&note.to_owned()), "{:?}", found.notes);
}

/// Two samples of one population, of which one has two large families and the other one, because the pass between them is a
/// little higher.
#[test]
fn the_height_of_one_pass_decides_nothing() {
    let mut higher = set("higher", Counted::Families, &[200, 200, 10]);
    let mut lower = set("lower", Counted::Families, &[400, 10]);
    let alone = compare(&[higher.clone(), lower.clone()]);
    assert_eq!(alone.measures[0].most[1], Some(0));
    higher.families_at_other_levels = vec![vec![190, 200, 10, 10], vec![410]];
    lower.families_at_other_levels = vec![vec![200, 200, 10], vec![410]];
    let found = compare(&[higher.clone(), lower]);
    let answer = found.answer();
    assert!(
        answer.starts_with("These grasps show no difference in families: "),
        "{answer}"
    );
    // More grasps of these sources would show no difference either, because the levels disagree.
    assert_eq!(
        found.measures[0].ratio([0, 1]).unwrap()[1].members_needed,
        None
    );
    assert!(!answer.contains("would show"), "{answer}");
    let told = |found: &DiversityComparison| found.measures[0].sets[0].unwrap();
    for (number, own) in told(&found).iter().zip(told(&alone)) {
        assert!((number.value - own.value).abs() < 1e-12);
        assert!(number.interval[0] <= own.interval[0] && number.interval[1] >= own.interval[1]);
    }
    assert!(
        found
            .notes
            .iter()
            .any(|note| note.contains("twice their level"))
    );
    // What differs at all levels is told, even if the intervals over all levels overlap.
    let mut some = set("some", Counted::Families, &[41; 10]);
    some.families_at_other_levels = vec![vec![10; 41], vec![205, 205]];
    let mut few = set("few", Counted::Families, &[205, 205]);
    few.families_at_other_levels = vec![vec![41; 10], vec![410]];
    let found = compare(&[some, few]);
    assert_eq!(found.measures[0].most, [Some(0); 3]);
    let mut many = set("many", Counted::Families, &[10; 41]);
    many.families_at_other_levels = vec![vec![5; 82], vec![41; 10]];
    let found = compare(&[higher, many]);
    assert_eq!(found.measures[0].most, [Some(1); 3]);
}

#[test]
fn families_of_different_levels_are_not_compared() {
    let at = |name: &str, counts: &[usize], barrier| {
        let mut set = set(name, Counted::Families, counts);
        set.level = Some(FamilyLevel {
            barrier,
            letting_go: Some(1.0),
        });
        set
    };
    let sets = |barrier| [at("a", &[100], 0.05), at("b", &[5; 20], barrier)];
    let found = compare(&sets(0.05));
    assert!(
        found
            .answer()
            .starts_with("b is the more diverse by families")
    );
    let found = compare(&sets(0.01));
    assert_eq!(
        found.answer(),
        "The families cannot be compared: the notes say why."
    );
    assert_eq!(found.sentence(), None);
    assert!(
        found.notes[0].contains("cannot be compared"),
        "{:?}",
        found.notes
    );
}

#[test]
fn the_same_sets_give_the_same_bytes_in_any_number_of_threads() {
    let sets = [
        set("a", Counted::Contacts, &[30, 9, 4, 1, 1, 1]),
        set("b", Counted::Contacts, &[12, 9, 9, 9, 3, 2, 1, 1]),
    ];
    let told = |threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| {
            let found = compare(&sets);
            format!("{:#}{}", found.to_json(), found.markdown())
        })
    };
    assert_eq!(told(1), told(3));
}

#[test]
fn the_picture_is_legible() {
    use crate::figure::testing::{assert_legible, gallery};
    let all = |name: &str, scale: usize| {
        let mut one = set(
            name,
            Counted::Families,
            &[scale, scale, 2 * scale, 9, 5, 3, 1, 1],
        );
        for of in [Counted::Types, Counted::Cells, Counted::Contacts] {
            let counts = vec![scale; 3 + of as usize];
            one.counts[of as usize] = set(name, of, &counts).counts[of as usize].clone();
        }
        one
    };
    let sets = [
        all("one.landscape", 10),
        all("other.landscape", 14),
        all("third.landscape", 30),
    ];
    let canvas = compare(&sets).chart().draw().unwrap();
    assert_legible(&canvas);
    gallery(&canvas, "diversity");
    for expected in ["order 1", "other.landscape", "effective number"] {
        assert!(canvas.texts().iter().any(|(text, _)| *text == expected));
    }
}
