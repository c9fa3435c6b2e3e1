//! Answers that are lines of JSON.

use serde_json::Value;

/// Why an answer is not valid.
pub(super) enum Misunderstood {
    Reported(String),
    Complaint(String),
}

/// Energy and gradient of an answer on a space with this number of tangents.
pub(super) fn read(
    answer: &str,
    tangents: usize,
) -> Result<(f64, Option<Vec<f64>>), Misunderstood> {
    let complain = |text: String| Err(Misunderstood::Complaint(text));
    let expected =
        format!("a line {{\"energy\": number, \"gradient\": [{tangents} numbers]}} is expected");
    let Ok(Value::Object(answer)) = serde_json::from_str(answer) else {
        let finite = !["NaN", "nan", "Infinity", "inf"]
            .iter()
            .any(|word| answer.contains(word));
        return complain(if finite {
            expected
        } else {
            "numbers must be finite; outside the domain answer {\"energy\": null}".to_owned()
        });
    };
    if let Some(message) = answer.get("error") {
        let text = message
            .as_str()
            .map_or_else(|| message.to_string(), str::to_owned);
        return Err(Misunderstood::Reported(text));
    }
    let energy = match answer.get("energy") {
        Some(Value::Null) => return Ok((f64::INFINITY, Some(vec![0.0; tangents]))),
        Some(Value::Number(number)) => number.as_f64(),
        _ => None,
    };
    let Some(energy) = energy else {
        return complain(expected);
    };
    let Some(gradient) = answer.get("gradient") else {
        return Ok((energy, None));
    };
    let numbers = gradient
        .as_array()
        .map(|list| list.iter().filter_map(Value::as_f64).collect());
    let numbers: Vec<f64> = numbers.unwrap_or_default();
    if numbers.len() != tangents || gradient.as_array().map(Vec::len) != Some(tangents) {
        return complain(expected);
    }
    Ok((energy, Some(numbers)))
}
