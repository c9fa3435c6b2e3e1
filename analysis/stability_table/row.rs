//! Results for one grasp: a line of the `.csv`.

use std::error::Error;
use std::fs;
use std::io::ErrorKind;
use std::path::Path;

/// Columns. Outcomes are 1 (held), 0 (not) or −1 (not simulated).
const COLUMNS: &str = "population,object,chain,net_wrench,friction,epsilon,sigma_m,force_closure,published,strict,firm,\
                       touch_friction,touch_epsilon,drop,at_once,six,rigid";

/// A chain's end: its measures and its outcomes.
#[expect(clippy::struct_excessive_bools, reason = "columns of a table")]
pub(crate) struct Row {
    pub(crate) population: String,
    pub(crate) object: String,
    pub(crate) chain: u64,
    pub(crate) net_wrench: f64,
    pub(crate) friction: f64,
    pub(crate) epsilon: f64,
    pub(crate) sigma_m: f64,
    pub(crate) force_closure: bool,
    pub(crate) published: bool,
    pub(crate) strict: bool,
    pub(crate) firm: bool,
    pub(crate) touch_friction: f64,
    pub(crate) touch_epsilon: f64,
    pub(crate) drop: Option<bool>,
    pub(crate) at_once: Option<bool>,
    pub(crate) six: Option<bool>,
    pub(crate) rigid: Option<bool>,
}

impl Row {
    fn to_line(&self) -> String {
        let flag = u8::from;
        let outcome = |held: Option<bool>| held.map_or(-1, i8::from);
        format!(
            "{},{},{},{:.6},{:.6},{:.6},{:.9},{},{},{},{},{:.6},{:.6},{},{},{},{}",
            self.population,
            self.object,
            self.chain,
            self.net_wrench,
            self.friction,
            self.epsilon,
            self.sigma_m,
            flag(self.force_closure),
            flag(self.published),
            flag(self.strict),
            flag(self.firm),
            self.touch_friction,
            self.touch_epsilon,
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
        let numbers: [f64; 14] = numbers.try_into().ok()?;
        let flag = |number: f64| number > 0.5;
        let outcome = |number: f64| (number >= 0.0).then_some(number > 0.5);
        Some(Self {
            population,
            object,
            chain,
            net_wrench: numbers[0],
            friction: numbers[1],
            epsilon: numbers[2],
            sigma_m: numbers[3],
            force_closure: flag(numbers[4]),
            published: flag(numbers[5]),
            strict: flag(numbers[6]),
            firm: flag(numbers[7]),
            touch_friction: numbers[8],
            touch_epsilon: numbers[9],
            drop: outcome(numbers[10]),
            at_once: outcome(numbers[11]),
            six: outcome(numbers[12]),
            rigid: outcome(numbers[13]),
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
