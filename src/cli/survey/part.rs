//! The flag `--task`: the part of a survey that one job of a scheduler does.

use anyhow::Context;
use serde::Serialize;

/// One of several parts of the populations of a survey.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub(super) struct Part {
    /// From 1 to `count`.
    number: usize,
    count: usize,
}

impl Part {
    /// The part that a user names: `3/64`.
    pub(super) fn named(text: &str) -> anyhow::Result<Self> {
        let numbers = || {
            let (number, count) = text.split_once('/')?;
            let (number, count) = (number.parse().ok()?, count.parse().ok()?);
            (1..=count)
                .contains(&number)
                .then_some(Self { number, count })
        };
        numbers().with_context(|| {
            format!(
                "invalid --task `{text}`: expected NUMBER/COUNT with 1 ≤ NUMBER ≤ COUNT, such as 3/64"
            )
        })
    }

    /// Every `count`-th item.
    pub(super) fn of<T>(self, all: &[T]) -> Vec<&T> {
        all.iter()
            .skip(self.number - 1)
            .step_by(self.count)
            .collect()
    }
}

impl std::fmt::Display for Part {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(formatter, "{} of {}", self.number, self.count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_share_everything() {
        let all: Vec<usize> = (0..7).collect();
        let part = |text| Part::named(text).unwrap().of(&all);
        assert_eq!(part("1/3"), [&0, &3, &6]);
        assert_eq!(part("2/3"), [&1, &4]);
        assert_eq!(part("3/3"), [&2, &5]);
        assert!(part("8/9").is_empty());
        assert_eq!(part("1/1").len(), all.len());
    }

    #[test]
    fn no_part_has_another_form() {
        for text in ["5/4", "0/3", "x", "", "3", "1/0", "0/0", "-1/3", "1/3/4"] {
            assert!(Part::named(text).is_err(), "{text}");
        }
    }
}
