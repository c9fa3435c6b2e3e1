//! The measures: their names, units and sources, and what is better.

use serde::Serialize;

/// A measure of a set of grasps. `docs/measures.md` explains each and shows where it misleads.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Measure {
    /// Mean Ferrari–Canny ε of the contact sets at friction 0.5; a grasp without force closure counts as 0.
    Epsilon,
    /// Mean Q1 of the `DexGraspNet` line.
    Q1,
    /// The same, where a grasp that is 5 mm deep counts as 0.
    ValidQ1,
    /// Mean of the greatest depth of each grasp.
    Penetration,
    /// The greatest depth of all grasps.
    DeepestPenetration,
    /// Mean distance of the digits from the object.
    ContactDistance,
    /// Mean difference between the farthest and the nearest or deepest digit.
    ContactConsistency,
    /// Mean number of links within 2 mm of the surface, either way.
    ContactLinks,
    /// Mean number of digits (without the palm) that touch.
    Digits,
    /// Standard deviation of the joints on each object.
    JointDeviation,
    /// Standard deviation of all numbers of all objects together.
    PooledDeviation,
    /// Share of the variance in the first principal component.
    Pca,
    /// Entropy of the joints.
    JointEntropy,
    /// Entropy of the position.
    PositionEntropy,
    /// Entropy of the numbers of the quaternion.
    OrientationEntropy,
    /// Unique grasps as the published code counts them.
    UniquePublished,
    /// The same, with the arguments in their order.
    UniqueOrdered,
    /// The same, with orientations seen.
    UniqueMended,
    /// Grasps that lie 5 mm apart in the metric of poses.
    Distinct,
    /// Effective number of types.
    Types,
    /// Effective number of cells of the taxonomy.
    Cells,
    /// Effective number of sets of contact regions.
    Regions,
    /// Vendi score.
    Vendi,
}

/// Which values of a measure are better.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Better {
    /// Greater values.
    More,
    /// Smaller values.
    Less,
    /// Neither.
    Neither,
}

/// What is known of a measure.
struct Entry {
    name: &'static str,
    title: &'static str,
    unit: &'static str,
    of_held: bool,
    better: Better,
    source: &'static str,
}

/// Source of the measures of `DexGraspBench`.
const DEX_GRASP_BENCH: &str = "DexGraspBench, src/task/eval_func/base.py";
/// Source of the Q1 of the `DexGraspNet` line.
const UNI_DEX_GRASP: &str = "UniDexGrasp, dexgrasp_generation/utils/eval_utils.py";
/// Source of the measures of `GraspQP`.
const GRASP_QP: &str = "GraspQP, graspqp_isaaclab utils/eval.py";
/// Source of effective numbers.
const HILL: &str = "Chao et al. 2014, Ecol. Monogr. 84, 45 (order 1)";

impl Measure {
    /// All measures, in the order of tables.
    pub const ALL: [Self; 23] = [
        Self::Epsilon,
        Self::Q1,
        Self::ValidQ1,
        Self::Penetration,
        Self::DeepestPenetration,
        Self::ContactDistance,
        Self::ContactConsistency,
        Self::ContactLinks,
        Self::Digits,
        Self::JointDeviation,
        Self::PooledDeviation,
        Self::Pca,
        Self::JointEntropy,
        Self::PositionEntropy,
        Self::OrientationEntropy,
        Self::UniquePublished,
        Self::UniqueOrdered,
        Self::UniqueMended,
        Self::Distinct,
        Self::Types,
        Self::Cells,
        Self::Regions,
        Self::Vendi,
    ];

    /// Its name in commands and files.
    pub fn name(self) -> &'static str {
        self.entry().name
    }

    /// Its name in texts, without a capital.
    pub fn title(self) -> &'static str {
        self.entry().title
    }

    /// Its unit; empty if it has none.
    pub fn unit(self) -> &'static str {
        self.entry().unit
    }

    /// Whether it counts only the grasps that hold, if that is known.
    pub fn of_held(self) -> bool {
        self.entry().of_held
    }

    /// Which values are better, by its publication.
    pub fn better(self) -> Better {
        self.entry().better
    }

    /// Where it is defined.
    pub fn source(self) -> &'static str {
        self.entry().source
    }

    /// The measure with this name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|measure| measure.name() == name)
    }

    /// Whether it grows with the number of grasps, so that only sets of equal size are comparable ([`Resampling::at`]).
    ///
    /// [`Resampling::at`]: super::Resampling::at
    pub fn grows(self) -> bool {
        self == Self::DeepestPenetration || self >= Self::JointEntropy
    }

    #[expect(
        clippy::too_many_lines,
        reason = "one paragraph a measure, in the order of the list"
    )]
    fn entry(self) -> Entry {
        use Better::{Less, More, Neither};
        let entry = |name, title, unit, of_held, better, source| Entry {
            name,
            title,
            unit,
            of_held,
            better,
            source,
        };
        match self {
            Self::Epsilon => entry(
                "epsilon",
                "ε at friction 0.5",
                "",
                false,
                More,
                "Ferrari and Canny 1992",
            ),
            Self::Q1 => entry("q1", "Q1", "", false, More, UNI_DEX_GRASP),
            Self::ValidQ1 => entry(
                "valid-q1",
                "Q1, 0 from a depth of 5 mm on",
                "",
                false,
                More,
                UNI_DEX_GRASP,
            ),
            Self::Penetration => entry(
                "penetration",
                "penetration",
                "m",
                false,
                Less,
                DEX_GRASP_BENCH,
            ),
            Self::DeepestPenetration => entry(
                "deepest-penetration",
                "deepest penetration of the set",
                "m",
                true,
                Less,
                "Dexonomy, dexonomy/op/compute_stats.py",
            ),
            Self::ContactDistance => entry(
                "contact-distance",
                "contact distance",
                "m",
                false,
                Less,
                DEX_GRASP_BENCH,
            ),
            Self::ContactConsistency => entry(
                "contact-consistency",
                "contact distance consistency",
                "m",
                false,
                Less,
                DEX_GRASP_BENCH,
            ),
            Self::ContactLinks => entry(
                "contact-links",
                "links in contact",
                "",
                false,
                Neither,
                DEX_GRASP_BENCH,
            ),
            Self::Digits => entry(
                "digits",
                "digits that touch",
                "",
                false,
                Neither,
                "Landscape, docs/measures.md",
            ),
            Self::JointDeviation => entry(
                "joint-deviation",
                "standard deviation of joints, by object",
                "rad",
                true,
                More,
                "Scene-Diffuser, scripts/grasp_gen_ur/test.py",
            ),
            Self::PooledDeviation => entry(
                "pooled-deviation",
                "standard deviation of pose and joints, all objects together",
                "rad",
                true,
                More,
                "DRO-Grasp, validate.py",
            ),
            Self::Pca => entry(
                "pca",
                "share of the first principal component",
                "",
                false,
                Less,
                "DexGraspBench, src/task/statistic.py",
            ),
            Self::JointEntropy => entry(
                "joint-entropy",
                "entropy of joints",
                "nats",
                true,
                More,
                GRASP_QP,
            ),
            Self::PositionEntropy => entry(
                "position-entropy",
                "entropy of position",
                "nats",
                true,
                More,
                GRASP_QP,
            ),
            Self::OrientationEntropy => entry(
                "orientation-entropy",
                "entropy of the quaternion",
                "nats",
                true,
                More,
                GRASP_QP,
            ),
            Self::UniquePublished => entry(
                "unique-published",
                "unique grasps an object, 2 cm, as published",
                "",
                true,
                More,
                GRASP_QP,
            ),
            Self::UniqueOrdered => entry(
                "unique-ordered",
                "unique grasps an object, 2 cm, arguments in order",
                "",
                true,
                More,
                GRASP_QP,
            ),
            Self::UniqueMended => entry(
                "unique-mended",
                "unique grasps an object, 2 cm, orientations seen",
                "",
                true,
                More,
                GRASP_QP,
            ),
            Self::Distinct => entry(
                "distinct",
                "distinct stable grasps an object, 5 mm",
                "",
                true,
                More,
                "after DexEvolve, arXiv:2602.15201",
            ),
            Self::Types => entry("types", "effective number of types", "", true, More, HILL),
            Self::Cells => entry("cells", "effective number of cells", "", true, More, HILL),
            Self::Regions => entry(
                "regions",
                "effective number of sets of contact regions",
                "",
                true,
                More,
                HILL,
            ),
            Self::Vendi => entry(
                "vendi",
                "Vendi score an object",
                "",
                true,
                More,
                "Friedman and Dieng 2023, vertaix/Vendi-Score",
            ),
        }
    }

    /// Least and greatest value that it may have.
    pub(super) fn range(self) -> [f64; 2] {
        match self {
            Self::Q1 | Self::ValidQ1 | Self::Pca => [0.0, 1.0],
            Self::Types | Self::Cells | Self::Regions | Self::Vendi => [1.0, f64::INFINITY],
            _ => [0.0, f64::INFINITY],
        }
    }
}
