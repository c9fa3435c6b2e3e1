use proptest::prelude::*;

use super::*;
use crate::topography::{MinimumId, Tree};

/// The four minima and the three deciding saddles of seven Lennard-Jones atoms, in PATHSAMPLE's layout.
const MIN: &str = "
  -15.9350430000   89.1D0   6   3.1  3.1  4.0
  -16.5053840000   9.2E+1  20   2.9  2.9  4.4
  -15.5330600000   88.5     2   2.0  3.0  4.0
  -15.5932100000   88.2     6   2.5  3.5  3.5
";
const TS: &str = "\
-15.4447340000 84.0 1 2 1 1.0 2.0 3.0\n\n\
-15.3198640000 83.0 1 1 4 1.0 2.0 3.0\n\
-15.2834210000 82.0 1 1 3 1.0 2.0 3.0\n\
-15.0333840000 82.0 1 2 4 1.0 2.0 3.0\n\
-14.8164000000 82.0 2 3 3 1.0 2.0 3.0\n";

#[test]
fn pathsample_makes_a_tree() {
    let (database, layout) = Database::parse(MIN, TS).unwrap();
    assert_eq!(layout, Layout::Pathsample);
    let vibrations = database.minima[0].vibrations.unwrap();
    assert_eq!(vibrations.log_product.to_bits(), 89.1_f64.to_bits());
    assert_eq!(vibrations.point_group_order, 6);
    assert_eq!(database.transition_states.len(), 5);
    let network = database.network();
    // The minima are sorted by energy, and the loop is gone.
    assert_eq!(network[NodeIndex::new(0)].members, [1]);
    assert_eq!(network.edge_count(), 4);
    let tree = Tree::from_network(&network, Evidence::Given);
    let height = |i, j| tree.minimax(MinimumId(i), MinimumId(j));
    assert_eq!(height(0, 1), Some(-15.444734));
    assert_eq!(height(0, 2), Some(-15.319864));
    assert_eq!(height(0, 3), Some(-15.283421));
}

#[test]
fn topsearch_numbers_its_minima() {
    let (database, layout) = Database::parse(
        "0 -15.59321\n2 -16.50538\n1 -15.53306\n",
        "0 2 -15.03338\n1 2 -15.02644",
    )
    .unwrap();
    assert_eq!(layout, Layout::Topsearch);
    assert_eq!(database.transition_states[0].ends, [0, 1]);
    assert_eq!(database.transition_states[1].ends, [2, 1]);
    assert_eq!(database.minima[0].vibrations, None);
}

#[test]
fn what_does_not_fit_is_told() {
    let good = "-1.0 0 1 0 0 0\n-0.5 0 1 0 0 0\n";
    for (min, ts, said) in [
        ("", "", "min.data contains no minima"),
        (
            "-1 2 3\n",
            "",
            "min.data, line 1: it has 3 fields, but a line has 6 or more (PATHSAMPLE) or 2 (topsearch)",
        ),
        (
            "\n0 -1\n-1.0 0 1 0 0 0",
            "",
            "min.data, line 3: it has the layout of PATHSAMPLE (6 fields), but min.data begins with that of topsearch",
        ),
        (
            good,
            "0 1 0.5",
            "ts.data, line 1: it has the layout of topsearch (3 fields), but min.data begins with that of PATHSAMPLE",
        ),
        (
            good,
            "0.5 0 1 1 2 0 0",
            "ts.data, line 1: it has 7 fields, but a line has 8 or more (PATHSAMPLE) or 3 (topsearch)",
        ),
        (
            "-1.0 x 1 0 0 0",
            "",
            "min.data, line 1, field 2: `x` is not a finite number",
        ),
        (
            "nan 0 1 0 0 0",
            "",
            "min.data, line 1, field 1: `nan` is not a finite number",
        ),
        (
            "-1 0 0 0 0 0",
            "",
            "min.data, line 1, field 3: `0` is not a whole number of operations, 1 or more",
        ),
        (
            "-1 0 1 0 0 ***",
            "",
            "min.data, line 1, field 6: `***` is not a finite number",
        ),
        (
            good,
            "0.5 0 1 1 2.0 0 0 0",
            "ts.data, line 1, field 5: `2.0` is not the number of a minimum",
        ),
        (
            good,
            "0.5 0 1 0 2 0 0 0",
            "ts.data, line 1, field 4: minimum 0 is not in min.data, which lists 2 minima, counted from 1",
        ),
        (
            good,
            "0.5 0 1 1 2 0 0 0\n0.5 0 1 1 3 0 0 0",
            "ts.data, line 2, field 5: minimum 3 is not in min.data, which lists 2 minima, counted from 1",
        ),
        (
            good,
            "0.5 0 1 1 2 0 0 0\n\n-1.5 0 1 2 1 0 0 0",
            "ts.data, line 3, field 1: the energy -1.5 lies below that of minimum 2 (-0.5, line 2 of min.data), which this \
             transition state joins",
        ),
        (
            "0 -1\n1 -2",
            "1 0 -1.5",
            "ts.data, line 1, field 3: the energy -1.5 lies below that of minimum 0 (-1, line 1 of min.data), which this \
             transition state joins",
        ),
        (
            "0 -1.03163\n1 -2.00000",
            "1 0 -1.03165",
            "ts.data, line 1, field 3: the energy -1.03165 lies below that of minimum 0 (-1.03163, line 1 of min.data), which \
             this transition state joins",
        ),
        (
            "0 -1\n0 -2",
            "",
            "min.data, line 2, field 1: minimum 0 is already on line 1",
        ),
        (
            "0 -1\n-1 -2",
            "",
            "min.data, line 2, field 1: `-1` is not the number of a minimum",
        ),
        (
            "0 -1\n1 -2",
            "0 2 0",
            "ts.data, line 1, field 2: minimum 2 is not in min.data, which lists 2 minima, counted from 0",
        ),
    ] {
        let error = Database::parse(min, ts).unwrap_err();
        assert_eq!(error.to_string(), said);
    }
}

/// Fortran leaves the letter out before an exponent of three digits.
#[test]
fn exponents_of_three_digits_without_a_letter_are_read() {
    for (text, value) in [
        ("0.12-103", 0.12e-103),
        ("-9.5+101", -9.5e101),
        ("1.5D-3", 1.5e-3),
        ("0.7E+02", 70.0),
        ("0.1-400", 0.0),
    ] {
        let minima = format!("-10.0 {text} 1 1.0 2.0 3.0\n");
        let read = Database::read(&minima, "").unwrap();
        let known = read.database.minima[0].vibrations.unwrap();
        assert_eq!(known.log_product.to_bits(), f64::to_bits(value), "{text}");
    }
    let error = Database::read("-10.0 0.1+400 1 1.0 2.0 3.0\n", "").unwrap_err();
    assert!(
        error
            .to_string()
            .contains("field 2: `0.1+400` is not a finite number"),
        "{error}"
    );
}

/// PATHSAMPLE's keyword IMFRQ writes a ninth column.
#[test]
fn further_columns_are_ignored_and_told() {
    let states = TS.replace('\n', " 17.5\n").replace("\n 17.5\n", "\n\n");
    let read = Database::read(MIN, &states).unwrap();
    assert_eq!(read.database, Database::parse(MIN, TS).unwrap().0);
    assert_eq!(read.layout, Layout::Pathsample);
    assert_eq!(
        read.notes,
        ["ts.data has more columns than are supported, and the last ones were ignored"]
    );
    assert!(Database::read(MIN, TS).unwrap().notes.is_empty());
}

/// Files hold rounded numbers.
#[test]
fn a_transition_state_within_rounding_of_its_minimum_is_raised_to_it() {
    let minima = "0 -10.0\n1 -5.0\n";
    let read = Database::read(minima, "0 1 -5.0000000001").unwrap();
    assert_eq!(
        read.database.transition_states[0].energy.to_bits(),
        (-5.0_f64).to_bits()
    );
    let [note] = &read.notes[..] else {
        panic!("{:?}", read.notes)
    };
    assert!(note.contains("were raised to it: 1"), "{note}");
    for below in ["0 1 -5.00000002", "0 1 -6"] {
        let error = Database::read(minima, below).unwrap_err();
        assert!(
            matches!(error, ExchangeError::BelowMinimum { .. }),
            "{error}"
        );
    }
}

/// The saddle of a landscape with one coordinate has no positive eigenvalue: its ln-product is 0, and known.
#[test]
fn a_known_product_of_1_is_no_placeholder() {
    let known = Vibrations::default();
    let database = |vibrations| Database {
        minima: vec![
            MinimumEntry {
                energy: 0.0,
                vibrations: Some(Vibrations {
                    log_product: 2.0,
                    ..known
                }),
            },
            MinimumEntry {
                energy: 1.0,
                vibrations,
            },
        ],
        transition_states: vec![TransitionStateEntry {
            energy: 3.0,
            ends: [0, 1],
            vibrations,
        }],
        vibrational_modes: None,
    };
    let again = |database: &Database| {
        let layout = Layout::Pathsample;
        Database::parse(&database.min_data(layout), &database.ts_data(layout))
            .unwrap()
            .0
    };
    assert_eq!(again(&database(None)), database(None));
    let read = again(&database(Some(known)));
    let vibrations = [
        read.minima[1].vibrations,
        read.transition_states[0].vibrations,
    ];
    for vibrations in vibrations {
        let product = vibrations.expect("it is known").log_product;
        assert!(product.abs() < 1e-290, "{product}");
    }
}

#[test]
fn one_unit_of_the_last_digit_is_rounding() {
    // Both are -1.031628; topsearch writes five decimals, and its rounding may go either way.
    let read = Database::read("0 -1.03162\n1 -2.00000", "1 0 -1.03163").unwrap();
    let state = read.database.transition_states[0].energy;
    assert_eq!(state.to_bits(), (-1.03162_f64).to_bits());
    assert!(read.notes[0].ends_with("were raised to it: 1"));
    let read = Database::read("0 -1.03162D-3\n1 -2.0D-3", "1 0 -1.03163D-3").unwrap();
    assert_eq!(read.notes.len(), 1);
}

#[test]
fn placeholders_are_written_where_nothing_is_known() {
    let database = Database {
        minima: vec![MinimumEntry {
            energy: -1.5,
            vibrations: None,
        }],
        ..Database::default()
    };
    let fields: Vec<String> = database
        .min_data(Layout::Pathsample)
        .split_whitespace()
        .map(str::to_owned)
        .collect();
    assert_eq!(fields, ["-1.5", "0.0", "1", "0.0", "0.0", "0.0"]);
}

prop_compose! {
    fn vibrations()(log_product in -1e3..1e3_f64, point_group_order in 1..121_u32, moments in proptest::array::uniform3(0.0..1e6_f64)) -> Vibrations {
        Vibrations { log_product, point_group_order, moments_of_inertia: moments, negative_curvature: None }
    }
}

prop_compose! {
    fn databases()(count in 1..12_usize, full in any::<bool>())(
        minima in proptest::collection::vec((any::<f64>().prop_filter("finite", |x| x.is_finite()), vibrations()), count),
        states in proptest::collection::vec((-1e-3..1e20_f64, vibrations(), 0..count, 0..count), 0..30),
        full in Just(full),
    ) -> Database {
        let heights: Vec<f64> = minima.iter().map(|(energy, _)| *energy).collect();
        Database {
            minima: minima.into_iter().map(|(energy, v)| MinimumEntry { energy, vibrations: full.then_some(v) }).collect(),
            transition_states: states.into_iter()
                .map(|(energy, v, a, b)| TransitionStateEntry {
                    energy: energy.max(heights[a]).max(heights[b]),
                    ends: [a, b],
                    vibrations: full.then_some(v),
                })
                .collect(),
            vibrational_modes: None,
        }
    }
}

proptest! {
    #[test]
    fn what_is_written_is_read_again(database in databases()) {
        let layout = if database.minima[0].vibrations.is_some() { Layout::Pathsample } else { Layout::Topsearch };
        let (min, ts) = (database.min_data(layout), database.ts_data(layout));
        let read = Database::parse(&min, &ts);
        prop_assert_eq!(read, Ok((database, layout)));
    }

    #[test]
    fn no_text_makes_it_panic(min in ".{0,80}", ts in "[-0-9. e\n]{0,80}") {
        let _ = Database::parse(&min, &ts);
        let _ = Database::parse("0 1\n1 2\n", &ts);
    }
}
