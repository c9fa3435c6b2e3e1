//! The page: its frame with style, scripts and data put in.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use sha2::{Digest, Sha256};

/// The frame. Its marks in double braces are replaced.
const FRAME: &str = include_str!("web/page.html");
const STYLE: &str = include_str!("web/page.css");

/// The scripts, in the order in which they are run; they form one script.
const SCRIPTS: [&str; 23] = [
    include_str!("vendor/three-0.187.0.min.js"),
    include_str!("web/dom.js"),
    include_str!("web/data.js"),
    include_str!("web/kinematics.js"),
    include_str!("web/state.js"),
    include_str!("web/filter.js"),
    include_str!("web/pen.js"),
    include_str!("web/words.js"),
    include_str!("web/tree.js"),
    include_str!("web/graph.js"),
    include_str!("web/way.js"),
    include_str!("web/table.js"),
    include_str!("web/matrix.js"),
    include_str!("web/trust.js"),
    include_str!("web/legend.js"),
    include_str!("web/likeness.js"),
    include_str!("web/scene.js"),
    include_str!("web/pins.js"),
    include_str!("web/flat.js"),
    include_str!("web/tangle.js"),
    include_str!("web/label.js"),
    include_str!("web/export.js"),
    include_str!("web/main.js"),
];

/// The page with these data, which are base64.
pub(super) fn page(data: &str) -> String {
    let script = SCRIPTS.join("\n");
    let hash = |text: &str| STANDARD.encode(Sha256::digest(text));
    let mut page = FRAME.to_owned();
    for (mark, text) in [
        ("{{script hash}}", hash(&script).as_str()),
        ("{{style hash}}", &hash(STYLE)),
        ("{{style}}", STYLE),
        ("{{data}}", data),
        ("{{script}}", &script),
    ] {
        page = page.replacen(mark, text, 1);
    }
    page
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_asks_for_nothing_and_ends_no_element_early() {
        let page = page("AAAA");
        assert!(page.contains(">AAAA</script>") && !page.contains("{{"));
        for (element, count) in [
            ("<script", 2),
            ("</script", 2),
            ("<style", 1),
            ("</style", 1),
        ] {
            assert_eq!(page.matches(element).count(), count, "{element}");
        }
        let own = &SCRIPTS[1..];
        for asks in ["https:", "fetch(", "XMLHttpRequest", "import(", "innerHTML"] {
            let script = own.iter().find(|script| script.contains(asks));
            assert!(
                script.is_none() && !STYLE.contains(asks) && !FRAME.contains(asks),
                "{asks}"
            );
        }
    }

    #[test]
    fn the_vendored_files_are_as_made() {
        let files: [(&str, &[u8]); 2] = [
            ("LICENSE", include_bytes!("vendor/LICENSE")),
            (
                "three-0.187.0.min.js",
                include_bytes!("vendor/three-0.187.0.min.js"),
            ),
        ];
        let line = |(name, bytes): (&str, &[u8])| {
            let digits = Sha256::digest(bytes).to_vec();
            let digits: Vec<String> = digits.iter().map(|byte| format!("{byte:02x}")).collect();
            format!("{}  {name}\n", digits.concat())
        };
        assert_eq!(files.map(line).concat(), include_str!("vendor/SHA256SUMS"));
    }

    /// Each file is read by people: no long lines, and a line that says what it is for.
    #[test]
    fn the_scripts_are_readable() {
        for script in &SCRIPTS[1..] {
            assert!(
                script.starts_with("// ") && script.lines().count() <= 600,
                "{}",
                &script[..40]
            );
            assert!(
                script
                    .lines()
                    .all(|line| line.chars().count() <= 160 && !line.ends_with(' '))
            );
        }
    }
}
