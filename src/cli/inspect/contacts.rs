//! Contacts without a hand, from a JSON file.

use anyhow::Context;

use super::Inspect;
use crate::cli::args::Common;
use crate::cli::printing::tell;
use crate::study::GivenContacts;

/// Judges the contacts in the bytes of the file that the command names.
pub(super) fn run(command: &Inspect, bytes: &[u8], common: &Common) -> anyhow::Result<()> {
    let name = command.file.display();
    let flags = [
        ("--grasp", !command.grasp.is_empty()),
        ("--each", command.each),
        ("--hand", command.of.hand.is_some()),
        ("--object", command.of.object.is_some()),
    ];
    if let Some((flag, _)) = flags.iter().find(|(_, given)| *given) {
        anyhow::bail!("{flag}: {name} contains bare contacts, not grasps");
    }
    let contacts = parse(bytes).with_context(|| format!("{name}"))?;
    let report = contacts.judge().with_context(|| format!("{name}"))?;
    tell(common, &report)
}

/// Parses the file; an error names the wrong field.
fn parse(bytes: &[u8]) -> anyhow::Result<GivenContacts> {
    const NO_CONTACTS: &str = "not a list of contacts (see `landscape inspect --help`)";
    let mut json = serde_json::Deserializer::from_slice(bytes);
    let file = serde_path_to_error::deserialize(&mut json).map_err(|error| {
        let place = error.path().to_string();
        let cause = anyhow::Error::new(error.into_inner());
        if place == "." {
            cause.context(NO_CONTACTS)
        } else {
            cause.context(place).context(NO_CONTACTS)
        }
    })?;
    json.end().context(NO_CONTACTS)?;
    Ok(file)
}
