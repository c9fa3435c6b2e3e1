//! The table of the 33 types, `data/taxonomy/feix.toml`.

use std::sync::LazyLock;

use serde::{Deserialize, Serialize};

use super::TaxonomyError;

/// The table as text.
const TABLE: &str = include_str!("../../../data/taxonomy/feix.toml");
/// Number of the little finger; digits in virtual fingers are 0 = palm, 1 = thumb … 5 = little.
const LITTLE: usize = 5;

/// How a hand controls an object.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Category {
    /// Hand and object move as one.
    Power,
    /// Between power and precision.
    Intermediate,
    /// The fingers can move the object.
    Precision,
}

/// The direction in which the hand presses, seen from the palm.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Opposition {
    /// Across the palm: fingers against palm.
    Palm,
    /// Along the palm: thumb against the pads of fingers.
    Pad,
    /// Transverse: against the side of a finger.
    Side,
}

/// Position of the thumb.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Thumb {
    /// Away from the palm, able to oppose the fingertips.
    Abducted,
    /// Beside the palm.
    Adducted,
}

/// Form of an object where it is held.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Form {
    /// As wide in all directions.
    Sphere,
    /// Long: a cylinder, a bar, a handle.
    Rod,
    /// Flat, held by its rim.
    Disk,
    /// Flat, held by its faces.
    Plate,
    /// A block with flat faces that is not thin.
    Box,
}

impl Form {
    /// All forms.
    pub const ALL: [Self; 5] = [Self::Sphere, Self::Rod, Self::Disk, Self::Plate, Self::Box];
}

/// One of the 33 grasp types.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GraspType {
    /// 1 to 33, as in the paper.
    pub number: u8,
    /// Name in the paper.
    pub name: String,
    /// Other names in use.
    pub aliases: Vec<String>,
    /// Power, intermediate or precision.
    pub category: Category,
    /// Palm, pad or side opposition.
    pub opposition: Opposition,
    /// Position of the thumb.
    pub thumb: Thumb,
    /// The opposing side: digits (0 = palm, 1 = thumb, 2 = index … 5 = little).
    pub vf1: Vec<usize>,
    /// The main fingers.
    pub vf2: Vec<usize>,
    /// Auxiliary digits.
    pub vf3: Vec<usize>,
    /// Cell of the taxonomy's table: category/opposition/vf2/thumb.
    pub cell: String,
    /// Usual forms of the object where it is held; empty means any.
    #[serde(rename = "object")]
    pub forms: Vec<Form>,
    /// Usual diameter or thickness of the object, millimetres; `None` means any. Engineering guidance, not from the paper.
    pub size_mm: Option<[f64; 2]>,
    /// Parts of the hand that touch, in words.
    pub contacts: Vec<String>,
    /// Distinguishing feature, in words.
    pub cue: String,
}

/// A point on which the sources of the table disagree.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Disagreement {
    /// Numbers of the types concerned.
    pub types: Vec<u8>,
    /// The positions of the sources, and the choice in the table.
    pub about: String,
}

/// The taxonomy of Feix et al. (2016).
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Taxonomy {
    /// Sources of the table.
    pub sources: Vec<String>,
    /// Points on which the sources disagree.
    #[serde(rename = "disagreement")]
    pub disagreements: Vec<Disagreement>,
    /// The types, by number.
    #[serde(rename = "type")]
    pub types: Vec<GraspType>,
}

impl GraspType {
    /// Distance of two types in the taxonomy as a tree: 0 the same, 1 in one cell, 2 of one category and opposition, 3 of
    /// one category, 4 otherwise. It is an ultrametric.
    pub fn distance(&self, other: &Self) -> u8 {
        match () {
            () if self.number == other.number => 0,
            () if self.cell == other.cell => 1,
            () if self.category != other.category => 4,
            () if self.opposition != other.opposition => 3,
            () => 2,
        }
    }

    /// Whether the digit (0 = palm, 1 = thumb …) is part of any virtual finger.
    pub fn uses(&self, digit: usize) -> bool {
        [&self.vf1, &self.vf2, &self.vf3]
            .iter()
            .any(|finger| finger.contains(&digit))
    }
}

/// The virtual finger in the notation of cells: `2`, `2-4`, `3-5`; digits that are not neighbours have commas.
pub(super) fn spell_digits(digits: &[usize]) -> String {
    let neighbours = digits.windows(2).all(|pair| pair[1] == pair[0] + 1);
    match digits {
        [first, .., last] if neighbours => format!("{first}-{last}"),
        _ => {
            let digits: Vec<String> = digits.iter().map(ToString::to_string).collect();
            digits.join(",")
        }
    }
}

/// Names of enum values in files.
macro_rules! spelled {
    ($($kind:ident { $($value:ident => $name:literal),* })*) => {$(
        impl $kind {
            /// The name that files and reports use.
            pub fn name(self) -> &'static str {
                match self { $(Self::$value => $name),* }
            }
        }
    )*};
}
spelled! {
    Category { Power => "power", Intermediate => "intermediate", Precision => "precision" }
    Opposition { Palm => "palm", Pad => "pad", Side => "side" }
    Thumb { Abducted => "abducted", Adducted => "adducted" }
    Form { Sphere => "sphere", Rod => "rod", Disk => "disk", Plate => "plate", Box => "box" }
}

impl Category {
    /// The category with this name.
    pub fn named(name: &str) -> Option<Self> {
        let all = [Self::Power, Self::Intermediate, Self::Precision];
        all.into_iter().find(|category| category.name() == name)
    }
}

impl Taxonomy {
    /// The table that comes with the program.
    ///
    /// # Panics
    /// Never: the table is part of the program, and a test reads it.
    pub fn feix() -> &'static Self {
        static FEIX: LazyLock<Taxonomy> =
            LazyLock::new(|| Taxonomy::parse(TABLE).expect("the table that is built in is valid"));
        &FEIX
    }

    /// Reads a table.
    ///
    /// # Errors
    /// If the text does not have the form of a table, types are not numbered from 1, a cell does not match its type, or two
    /// types share a name.
    pub fn parse(text: &str) -> Result<Self, TaxonomyError> {
        let table: Self = toml::from_str(text)?;
        for (place, entry) in table.types.iter().enumerate() {
            let refuse = |problem: String| {
                Err(TaxonomyError::Type {
                    name: entry.name.clone(),
                    problem,
                })
            };
            if usize::from(entry.number) != place + 1 {
                return refuse(format!(
                    "its number is {}, but its place is {}",
                    entry.number,
                    place + 1
                ));
            }
            let cell = [
                entry.category.name(),
                entry.opposition.name(),
                &spell_digits(&entry.vf2),
                entry.thumb.name(),
            ]
            .join("/");
            if entry.cell != cell {
                return refuse(format!("its cell is {cell}, not {}", entry.cell));
            }
            let digits = [&entry.vf1, &entry.vf2, &entry.vf3];
            if digits
                .iter()
                .any(|finger| finger.iter().any(|d| *d > LITTLE))
            {
                return refuse(format!("digits are numbered 0 to {LITTLE}"));
            }
            if let Some([low, high]) = entry.size_mm
                && !(low > 0.0 && high > low)
            {
                return refuse(format!("size_mm = [{low}, {high}] is not a range"));
            }
            let names = || std::iter::once(&entry.name).chain(&entry.aliases);
            if let Some(name) = names().find(|name| table.named(name) != Some(entry)) {
                return refuse(format!("{name} is also the name of another type"));
            }
        }
        Ok(table)
    }

    /// The type with this number, 1 to 33.
    pub fn numbered(&self, number: u8) -> Option<&GraspType> {
        self.types.get(usize::from(number).checked_sub(1)?)
    }

    /// The type with this name, alias or number; case, spaces, hyphens and underscores are ignored.
    ///
    /// ```
    /// let feix = landscape::evaluation::taxonomy::Taxonomy::feix();
    /// assert_eq!(feix.named("sphere 4-finger").map(|entry| entry.number), Some(26));
    /// assert_eq!(feix.named("3").map(|entry| entry.name.as_str()), Some("Medium Wrap"));
    /// ```
    pub fn named(&self, name: &str) -> Option<&GraspType> {
        let key = |text: &str| -> String {
            let letters = text.chars().filter(|c| c.is_alphanumeric());
            letters.flat_map(char::to_lowercase).collect()
        };
        if let Ok(number) = name.trim().parse() {
            return self.numbered(number);
        }
        let wanted = key(name);
        self.types.iter().find(|entry| {
            key(&entry.name) == wanted || entry.aliases.iter().any(|alias| key(alias) == wanted)
        })
    }

    /// The cells, in the order of their first types.
    pub fn cells(&self) -> Vec<&str> {
        let mut cells: Vec<&str> = Vec::new();
        for entry in &self.types {
            if !cells.contains(&entry.cell.as_str()) {
                cells.push(&entry.cell);
            }
        }
        cells
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_counts_as_published() {
        let feix = Taxonomy::feix();
        let count = |test: &dyn Fn(&GraspType) -> bool| {
            feix.types.iter().filter(|entry| test(entry)).count()
        };
        assert_eq!(feix.types.len(), 33);
        let categories = [Category::Power, Category::Precision, Category::Intermediate];
        assert_eq!(
            categories.map(|category| count(&|entry| entry.category == category)),
            [15, 12, 6]
        );
        let oppositions = [Opposition::Palm, Opposition::Pad, Opposition::Side];
        assert_eq!(
            oppositions.map(|opposition| count(&|entry| entry.opposition == opposition)),
            [10, 16, 7]
        );
        assert_eq!(count(&|entry| entry.thumb == Thumb::Abducted), 23);
        let adducted: Vec<u8> = (feix.types.iter())
            .filter(|entry| entry.thumb == Thumb::Adducted)
            .map(|entry| entry.number)
            .collect();
        assert_eq!(adducted, [4, 5, 15, 16, 17, 22, 25, 29, 30, 32]);

        let cells = feix.cells();
        assert_eq!(cells.len(), 17);
        let mut sizes: Vec<usize> = cells
            .iter()
            .map(|cell| count(&|entry| entry.cell == *cell))
            .collect();
        sizes.sort_unstable();
        assert_eq!(sizes, [1, 1, 1, 1, 1, 1, 1, 1, 1, 2, 2, 2, 3, 3, 3, 4, 5]);
        assert_eq!(feix.sources.len(), 4);
        assert_eq!(feix.disagreements.len(), 6);
        // Palm opposition has the palm as its first virtual finger, and no other.
        assert!(
            feix.types
                .iter()
                .all(|entry| (entry.vf1 == [0]) == (entry.opposition == Opposition::Palm))
        );
    }

    #[test]
    fn the_distance_is_an_ultrametric() {
        let types = &Taxonomy::feix().types;
        for a in types {
            for b in types {
                assert_eq!(a.distance(b), b.distance(a));
                for c in types {
                    assert!(a.distance(c) <= a.distance(b).max(b.distance(c)));
                }
            }
        }
    }

    #[test]
    fn broken_tables_are_refused() {
        let refused = |from: &str, to: &str| {
            assert!(TABLE.contains(from), "{from}");
            Taxonomy::parse(&TABLE.replacen(from, to, 1)).map_err(|error| error.to_string())
        };
        let told = |from, to, what: &str| {
            let error = refused(from, to).unwrap_err();
            assert!(error.contains(what), "{error}");
        };
        told("number = 7", "number = 8", "its place is 7");
        told(
            "cell = \"power/palm/3-5",
            "cell = \"power/palm/2-5",
            "Index Finger Extension",
        );
        told("vf3 = [3, 4, 5]", "vf3 = [3, 4, 6]", "0 to 5");
        told("size_mm = [60, 120]", "size_mm = [60, 12]", "not a range");
        told(
            "aliases = [\"Hook\"]",
            "aliases = [\"ring\"]",
            "another type",
        );
        told("thumb = ", "tumb = ", "tumb");
        assert!(Taxonomy::feix().named("thumbs up").is_none());
        assert!(Taxonomy::feix().named("34").is_none());
    }
}
