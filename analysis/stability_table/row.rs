//! Results for one grasp: a line of the `.csv`.

use std::error::Error;
use std::fs;
use std::io::ErrorKind;
use std::path::Path;

/// Columns. Outcomes are 1 (held), 0 (not) or −1 (not simulated).
const COLUMNS: &str = "population,object,chain,sigma_m,strict,drop,at_once,six,rigid";

/// A chain's end: its measures and its outcomes.
pub(crate) struct Row {
    pub(crate) population: String,
    pub(crate) object: String,
    pub(crate) chain: u64,
    pub(crate) sigma_m: f64,
    pub(crate) strict: bool,
    pub(crate) drop: Option<bool>,
    pub(crate) at_once: Option<bool>,
    pub(crate) six: Option<bool>,
    pub(crate) rigid: Option<bool>,
}

impl Row {
    fn to_line(&self) -> String {
        let outcome = |held: Option<bool>| held.map_or(-1, i8::from);
        format!(
            "{},{},{},{:.9},{},{},{},{},{}",
            self.population,
            self.object,
            self.chain,
            self.sigma_m,
            u8::from(self.strict),
            outcome(self.drop),
            outcome(self.at_once),
            outcome(self.six),
            outcome(self.rigid),
        )
    }

    fn from_line(line: &str) -> Option<Self> {
        let mut cells = line.split(',');
        let population = cells.next()?.to_owned();
        let object = cells.next()?.to_owned();
        let chain = cells.next()?.parse().ok()?;
        let numbers: Vec<f64> = cells.map_while(|cell| cell.parse().ok()).collect();
        let numbers: [f64; 6] = numbers.try_into().ok()?;
        let outcome = |number: f64| (number >= 0.0).then_some(number > 0.5);
        Some(Self {
            population,
            object,
            chain,
            sigma_m: numbers[0],
            strict: numbers[1] > 0.5,
            drop: outcome(numbers[2]),
            at_once: outcome(numbers[3]),
            six: outcome(numbers[4]),
            rigid: outcome(numbers[5]),
        })
    }
}

pub(crate) fn read(csv: &Path) -> Result<Vec<Row>, Box<dyn Error>> {
    let text = match fs::read_to_string(csv) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(Vec::new()),
        text => text?,
    };
    let mut lines = text.lines();
    if lines.next() != Some(COLUMNS) {
        return Ok(Vec::new());
    }
    Ok(lines.filter_map(Row::from_line).collect())
}

pub(crate) fn write(csv: &Path, rows: &[Row]) -> Result<(), Box<dyn Error>> {
    let lines: Vec<String> = rows.iter().map(Row::to_line).collect();
    let text = format!("{COLUMNS}\n{}\n", lines.join("\n"));
    let partial = csv.with_extension("csv.partial");
    fs::write(&partial, text)?;
    Ok(fs::rename(partial, csv)?)
}
