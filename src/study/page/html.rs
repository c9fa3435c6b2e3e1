//! The page: its frame with style, scripts and data put in.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use sha2::{Digest, Sha256};

/// The frame. Its marks in double braces are replaced.
const FRAME: &str = include_str!("web/page.html");
const STYLE: &str = include_str!("web/page.css");

/// The parts of three.js, and the bundle of the modules in `web`. `vendor/make.sh` makes both.
const THREE: &str = include_str!("vendor/three-0.187.0.min.js");
const SCRIPT: &str = include_str!("vendor/page.min.js");

/// The page with these data, which are base64.
pub(super) fn page(data: &str) -> String {
    let hash = |text: &str| STANDARD.encode(Sha256::digest(text));
    let mut page = FRAME.to_owned();
    for (mark, text) in [
        ("{{three hash}}", hash(THREE).as_str()),
        ("{{script hash}}", &hash(SCRIPT)),
        ("{{style hash}}", &hash(STYLE)),
        ("{{style}}", STYLE),
        ("{{data}}", data),
        ("{{three}}", THREE),
        ("{{script}}", SCRIPT),
    ] {
        page = page.replacen(mark, text, 1);
    }
    page
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::Path;

    use super::*;

    #[test]
    fn the_page_asks_for_nothing_and_ends_no_element_early() {
        let page = page("AAAA");
        assert!(page.contains(">AAAA</script>") && !page.contains("{{"));
        for (element, count) in [
            ("<script", 3),
            ("</script", 3),
            ("<style", 1),
            ("</style", 1),
        ] {
            assert_eq!(page.matches(element).count(), count, "{element}");
        }
        for asks in ["https:", "fetch(", "XMLHttpRequest", "import(", "innerHTML"] {
            let asks = [SCRIPT, STYLE, FRAME].map(|text| text.contains(asks));
            assert_eq!(asks, [false; 3]);
        }
    }

    /// Only a directive at the very start makes a script strict.
    #[test]
    fn the_script_is_strict() {
        assert!(SCRIPT.starts_with("\"use strict\";"));
    }

    /// The sums are those of the bundle and of the modules that it was made of.
    #[test]
    fn the_bundle_is_made_of_the_modules() {
        let vendor = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/study/page/vendor");
        let modules = fs::read_dir(vendor.join("../web")).unwrap();
        let modules = modules.map(|entry| entry.unwrap().file_name().into_string().unwrap());
        let mut modules: Vec<String> = modules
            .filter(|name| Path::new(name).extension() == Some("js".as_ref()))
            .map(|name| format!("../web/{name}"))
            .collect();
        modules.sort_unstable();
        let made = ["LICENSE", "three-0.187.0.min.js", "page.min.js"].map(str::to_owned);
        let sums = made.into_iter().chain(modules).map(|name| {
            let digits = Sha256::digest(fs::read(vendor.join(&name)).unwrap()).to_vec();
            let digits: Vec<String> = digits.iter().map(|byte| format!("{byte:02x}")).collect();
            format!("{}  {name}\n", digits.concat())
        });
        let sums: String = sums.collect();
        assert!(
            sums == include_str!("vendor/SHA256SUMS"),
            "src/study/page/web has changed since its bundle was made: run src/study/page/vendor/make.sh"
        );
    }
}
