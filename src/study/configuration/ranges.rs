//! Ranges of the numbers in files of settings.

use toml::{Table, Value};

use crate::limits::{
    Beyond, COUNT_SETTING, COUNT_SETTING_OR_ZERO, EFFORT_SETTING, Limit, NEIGHBOURS_SETTING,
    POSITIVE_SETTING, SEED_SETTING, SETTING,
};

/// Keys of numbers that are not merely positive. All others that may have a fraction are [`POSITIVE_SETTING`]s, and all
/// counts are [`COUNT_SETTING`]s.
const RANGES: [(&str, Limit); 11] = [
    ("barrier", SETTING),
    ("ceiling", SETTING),
    ("max_evaluations", EFFORT_SETTING),
    ("max_searches", EFFORT_SETTING),
    ("max_steps", EFFORT_SETTING),
    ("neighbours", NEIGHBOURS_SETTING),
    ("replicas", COUNT_SETTING_OR_ZERO),
    ("roughness", SETTING),
    ("searches", COUNT_SETTING_OR_ZERO),
    ("seed", SEED_SETTING),
    ("segments", NEIGHBOURS_SETTING),
];

/// Checks the numbers that a file gives; the error has the key with its sections. `typed` is the file as its settings have
/// read it, so that a number that may have a fraction is one whether or not it is written with a point.
pub(super) fn check(given: &Table, typed: &Table) -> Result<(), (String, Beyond)> {
    for (key, value) in given {
        let value = typed.get(key).unwrap_or(value);
        let (value, usual) = match (value, given[key].as_table()) {
            (Value::Table(typed), Some(given)) => {
                check(given, typed)
                    .map_err(|(under, beyond)| (format!("{key}.{under}"), beyond))?;
                continue;
            }
            (Value::Float(number), _) => (*number, POSITIVE_SETTING),
            (Value::Integer(number), _) => (*number as f64, COUNT_SETTING),
            _ => continue,
        };
        let limit = RANGES
            .iter()
            .find_map(|(name, limit)| (name == key).then_some(*limit));
        limit
            .unwrap_or(usual)
            .check(value)
            .map_err(|beyond| (key.clone(), beyond))?;
    }
    Ok(())
}
