//! Looks of labels: a colour and a symbol, so that many labels can be told apart in colour, in grey and by colour-blind
//! readers.

use super::canvas::Canvas;
use super::style::Colour;
use super::theme::{LINE, OTHER, PALETTE, SHADES, UNLISTED, WHITE};

/// Radius of the white heart of an open look, as a share of the radius of the symbol.
pub const HEART: f64 = 0.45;

/// The form of a mark. All symbols of one radius have one area, that of the disc.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Symbol {
    /// A circle.
    Disc,
    /// A square on its side.
    Square,
    /// A triangle on its side.
    Triangle,
    /// A square on its corner.
    Diamond,
    /// A triangle on its corner.
    Inverted,
    /// A plus of five squares.
    Cross,
}

impl Symbol {
    /// All symbols, in the order in which looks use them.
    pub const ALL: [Self; 6] = [
        Self::Disc,
        Self::Square,
        Self::Triangle,
        Self::Diamond,
        Self::Inverted,
        Self::Cross,
    ];

    /// Name in the data of pages.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Disc => "disc",
            Self::Square => "square",
            Self::Triangle => "triangle",
            Self::Diamond => "diamond",
            Self::Inverted => "inverted",
            Self::Cross => "cross",
        }
    }

    /// Corners around the origin, y downward, of the symbol with the area of a disc of this radius, with all edges moved
    /// outward by `grown`; `None` for the disc itself.
    pub fn corners(self, radius: f64, grown: f64) -> Option<Vec<[f64; 2]>> {
        let area = std::f64::consts::PI * radius * radius;
        let triangle = |down: f64| {
            // Distance of the sides from the middle.
            let inner = (area / 27.0_f64.sqrt()).sqrt() + grown;
            let half = 3.0_f64.sqrt() * inner;
            vec![
                [-half, down * inner],
                [half, down * inner],
                [0.0, -2.0 * down * inner],
            ]
        };
        match self {
            Self::Disc => None,
            Self::Square => {
                let half = 0.5 * area.sqrt() + grown;
                Some(vec![
                    [-half, -half],
                    [half, -half],
                    [half, half],
                    [-half, half],
                ])
            }
            Self::Triangle => Some(triangle(1.0)),
            Self::Diamond => {
                let reach = std::f64::consts::SQRT_2 * (0.5 * area.sqrt() + grown);
                Some(vec![
                    [0.0, -reach],
                    [reach, 0.0],
                    [0.0, reach],
                    [-reach, 0.0],
                ])
            }
            Self::Inverted => Some(triangle(-1.0)),
            Self::Cross => {
                let half = 0.5 * (area / 5.0).sqrt();
                let (near, far) = (half + grown, 3.0 * half + grown);
                Some(vec![
                    [-near, -far],
                    [near, -far],
                    [near, -near],
                    [far, -near],
                    [far, near],
                    [near, near],
                    [near, far],
                    [-near, far],
                    [-near, near],
                    [-far, near],
                    [-far, -near],
                    [-near, -near],
                ])
            }
        }
    }

    /// How far it reaches to the side, upward and downward, as multiples of the radius.
    pub(super) fn reach(self) -> [f64; 3] {
        let Some(corners) = self.corners(1.0, 0.0) else {
            return [1.0; 3];
        };
        let farthest = |along: fn(&[f64; 2]) -> f64| corners.iter().map(along).fold(0.0, f64::max);
        [
            farthest(|corner| corner[0]),
            farthest(|corner| -corner[1]),
            farthest(|corner| corner[1]),
        ]
    }
}

/// The hue of a category of grasps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Hue {
    /// Precision.
    Green,
    /// Intermediate.
    Yellow,
    /// Power.
    Red,
}

/// What a label looks like in pictures.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Look {
    /// Its colour.
    pub colour: Colour,
    /// Its form.
    pub symbol: Symbol,
    /// Whether it has a white heart.
    pub open: bool,
}

impl Look {
    /// Number of looks of one hue.
    pub const OF_HUE: usize = SHADES[0].len() * Symbol::ALL.len();
    /// Number of looks that labels take in turn.
    pub const IN_TURN: usize = PALETTE.len() * Symbol::ALL.len();

    /// A disc of a colour.
    pub const fn disc(colour: Colour) -> Self {
        Self {
            colour,
            symbol: Symbol::Disc,
            open: false,
        }
    }

    /// Look number `number` of a hue. Number 0 is a disc of the hue's plain colour. Neighbours differ both in shade and in
    /// symbol. The looks repeat after [`Look::OF_HUE`].
    pub const fn of_hue(hue: Hue, number: usize) -> Self {
        let shades = &SHADES[hue as usize];
        let turn = number % Self::OF_HUE;
        Self {
            colour: shades[turn % shades.len()],
            symbol: Symbol::ALL[(turn + turn / Symbol::ALL.len()) % Symbol::ALL.len()],
            open: false,
        }
    }

    /// Look number `number` of labels that mean nothing to the program: all colours as discs, then with the next symbol.
    /// The looks repeat after [`Look::IN_TURN`].
    pub const fn in_turn(number: usize) -> Self {
        let turn = number % Self::IN_TURN;
        Self {
            colour: PALETTE[turn % PALETTE.len()],
            symbol: Symbol::ALL[turn / PALETTE.len()],
            open: false,
        }
    }

    /// The same look with a white heart.
    #[must_use]
    pub const fn opened(self) -> Self {
        Self { open: true, ..self }
    }

    /// Draws it with a dark rim of the given width outside.
    pub(super) fn draw(self, canvas: &mut Canvas, centre: [f64; 2], radius: f64, rim: f64) {
        if rim > 0.0 {
            canvas.symbol(self.symbol, centre, (radius, rim), LINE);
        }
        canvas.symbol(self.symbol, centre, (radius, 0.0), self.colour);
        if self.open {
            canvas.circle(centre, HEART * radius, WHITE);
        }
    }
}

/// Looks of the labels that look alike in all pictures, in the order of legends. All other labels take looks in turn, in
/// alphabetical order; in legends they stand between the known and the grey ones.
///
/// # Examples
/// ```
/// use landscape::figure::{Key, Look};
///
/// let key = Key::default();
/// let looks = key.looks(["hook", "unlisted", "Power", "cup", "hook"].into_iter());
/// let labels: Vec<&str> = looks.iter().map(|(label, _)| *label).collect();
/// assert_eq!(labels, ["Power", "cup", "hook", "unlisted"]);
/// assert_eq!(looks[2].1, Look::in_turn(1));
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Key {
    /// Labels that are kinds; by default the three categories of grasps.
    pub known: Vec<(String, Look)>,
    /// Labels that are no kinds: `other`, `unlisted` and `not_applicable`.
    pub greys: Vec<(String, Look)>,
}

impl Default for Key {
    fn default() -> Self {
        let entry = |label: &str, look| (label.to_owned(), look);
        Self {
            known: vec![
                entry("precision", Look::of_hue(Hue::Green, 0)),
                entry("intermediate", Look::of_hue(Hue::Yellow, 0)),
                entry("power", Look::of_hue(Hue::Red, 0)),
            ],
            greys: vec![
                entry("other", Look::disc(OTHER)),
                entry("unlisted", Look::disc(UNLISTED)),
                entry("not_applicable", Look::disc(UNLISTED).opened()),
            ],
        }
    }
}

impl Key {
    /// All labels with a look of their own.
    pub fn entries(&self) -> impl Iterator<Item = (&str, Look)> {
        let all = self.known.iter().chain(&self.greys);
        all.map(|(label, look)| (label.as_str(), *look))
    }

    /// The look of a label that has one of its own; case is ignored.
    pub fn look(&self, label: &str) -> Option<Look> {
        self.entries()
            .find(|(known, _)| known.eq_ignore_ascii_case(label))
            .map(|(_, look)| look)
    }

    /// The different ones of these labels, with their looks, in the order of a legend.
    pub fn looks<'a>(&self, labels: impl Iterator<Item = &'a str>) -> Vec<(&'a str, Look)> {
        let rank = |label: &str| {
            let place = self
                .entries()
                .position(|(known, _)| known.eq_ignore_ascii_case(label));
            match place {
                Some(place) if place < self.known.len() => (0, place),
                Some(place) => (2, place),
                None => (1, 0),
            }
        };
        let mut labels: Vec<((usize, usize), &str)> =
            labels.map(|label| (rank(label), label)).collect();
        labels.sort_unstable();
        labels.dedup();
        let mut others = 0;
        let mut look = |label| {
            self.look(label).unwrap_or_else(|| {
                others += 1;
                Look::in_turn(others - 1)
            })
        };
        (labels.into_iter())
            .map(|(_, label)| (label, look(label)))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::super::theme::UNLABELLED;
    use super::*;

    /// Full protanopia and deuteranopia in linear RGB, after normal sight. Source: Machado, Oliveira and Fernandes (2009),
    /// doi:10.1109/TVCG.2009.113, severity 1.
    const SIGHTS: [[[f64; 3]; 3]; 3] = [
        [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        [
            [0.152_286, 1.052_583, -0.204_868],
            [0.114_503, 0.786_281, 0.099_216],
            [-0.003_882, -0.048_116, 1.051_998],
        ],
        [
            [0.367_322, 0.860_646, -0.227_968],
            [0.280_085, 0.672_501, 0.047_413],
            [-0.011_820, 0.042_940, 0.968_881],
        ],
    ];

    fn times(matrix: &[[f64; 3]; 3], vector: [f64; 3]) -> [f64; 3] {
        matrix.map(|row| row.iter().zip(vector).map(|(a, b)| a * b).sum())
    }

    /// Lightness and the two chromatic coordinates of CIELAB (white D65).
    fn lab(colour: Colour, sight: &[[f64; 3]; 3]) -> [f64; 3] {
        let linear = |channel: u8| {
            let c = f64::from(channel) / 255.0;
            if c <= 0.04045 {
                c / 12.92
            } else {
                libm::pow((c + 0.055) / 1.055, 2.4)
            }
        };
        let light = times(sight, colour.rgb.map(linear)).map(|c| c.clamp(0.0, 1.0));
        let tristimulus = [
            [0.412_456_4, 0.357_576_1, 0.180_437_5],
            [0.212_672_9, 0.715_152_2, 0.072_175],
            [0.019_333_9, 0.119_192, 0.950_304_1],
        ];
        let [x, y, z] = times(&tristimulus, light);
        let [x, y, z] = [x / 0.950_47, y, z / 1.088_83].map(|part| {
            if part > 0.008_856 {
                libm::cbrt(part)
            } else {
                7.787 * part + 16.0 / 116.0
            }
        });
        [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
    }

    /// Least difference (CIE 1976) of two colours for all kinds of sight.
    fn difference(a: Colour, b: Colour) -> f64 {
        let gap = |sight| {
            let (a, b) = (lab(a, sight), lab(b, sight));
            let squares = a.iter().zip(b).map(|(a, b)| (a - b).powi(2));
            squares.sum::<f64>().sqrt()
        };
        SIGHTS.iter().map(gap).fold(f64::INFINITY, f64::min)
    }

    fn differ(colours: &[Colour], least: f64) {
        for (k, a) in colours.iter().enumerate() {
            for b in &colours[..k] {
                let gap = difference(*a, *b);
                assert!(gap >= least, "{a:?} and {b:?}: {gap}");
            }
        }
    }

    #[test]
    fn colours_of_one_symbol_differ_for_all_readers() {
        let shades: Vec<Colour> = SHADES.concat();
        differ(
            &[&shades[..], &[UNLISTED, OTHER, UNLABELLED]].concat(),
            10.0,
        );
        differ(&[&PALETTE[..], &[UNLISTED, OTHER]].concat(), 9.0);
    }

    #[test]
    fn shades_of_a_hue_differ_in_grey_print() {
        for shades in SHADES {
            for (k, a) in shades.iter().enumerate() {
                for b in &shades[..k] {
                    let [a, b] = [a, b].map(|shade| lab(*shade, &SIGHTS[0])[0]);
                    assert!((a - b).abs() >= 20.0, "lightness {a} and {b} of 100");
                }
            }
        }
    }

    #[test]
    fn looks_repeat_only_after_all_are_used() {
        let all_differ = |looks: &[Look]| {
            let repeats = |k: usize| looks[..k].contains(&looks[k]);
            !(0..looks.len()).any(repeats)
        };
        for hue in [Hue::Green, Hue::Yellow, Hue::Red] {
            let looks: Vec<Look> = (0..Look::OF_HUE).map(|k| Look::of_hue(hue, k)).collect();
            assert!(all_differ(&looks));
            assert_eq!(Look::of_hue(hue, Look::OF_HUE), looks[0]);
            for pair in looks.windows(2) {
                assert!(pair[0].colour != pair[1].colour && pair[0].symbol != pair[1].symbol);
            }
        }
        let looks: Vec<Look> = (0..Look::IN_TURN).map(Look::in_turn).collect();
        assert!(all_differ(&looks));
        assert_eq!(Look::in_turn(Look::IN_TURN), looks[0]);
    }

    #[test]
    fn symbols_have_the_area_of_the_disc() {
        for symbol in Symbol::ALL {
            let Some(corners) = symbol.corners(2.0, 0.0) else {
                assert_eq!(symbol, Symbol::Disc);
                continue;
            };
            let next = corners.iter().cycle().skip(1);
            let doubled: f64 = corners
                .iter()
                .zip(next)
                .map(|(a, b)| a[0] * b[1] - a[1] * b[0])
                .sum();
            let area = 0.5 * doubled.abs();
            assert!(
                (area - 4.0 * std::f64::consts::PI).abs() < 1e-9,
                "{symbol:?}: {area}"
            );
        }
    }

    #[test]
    fn known_labels_keep_their_look_whatever_else_is_listed() {
        let key = Key::default();
        let alone = key.looks(["power"].into_iter());
        let among = key.looks(["hook", "Power", "lateral", "precision", "other"].into_iter());
        assert_eq!(among[1], ("Power", alone[0].1));
        assert_eq!(among[4].0, "other");
        for (k, (_, look)) in among.iter().enumerate() {
            assert!(among[..k].iter().all(|(_, other)| other != look));
        }
    }
}
