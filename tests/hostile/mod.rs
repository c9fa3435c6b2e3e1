//! Text from files stays text: any name is preserved in every format and cannot control a terminal or a parser.

use landscape::figure::{BarrierPicture, DisconnectivityPicture};
use landscape::topography::{
    Edge, Evidence, Minimum, MinimumId, Network, Tree, dot, graphml, newick, tree_json,
};
use proptest::prelude::*;

use crate::desk::Desk;

/// Three minima, the first two joined below the third.
fn network() -> Network {
    let mut network = Network::default();
    for row in 0..3 {
        network.add_node(Minimum {
            coordinates: Vec::new(),
            energy: f64::from(row),
            members: vec![0; 4],
        });
    }
    for (a, b, height) in [(0_u32, 1_u32, 3.0), (1, 2, 5.0)] {
        let edge = Edge {
            height,
            evidence: Evidence::Saddle,
            term: Some("a<b&\u{1b}".to_owned()),
            length: 1.0,
        };
        network.add_edge(a.into(), b.into(), edge);
    }
    network
}

fn any_name() -> impl Strategy<Value = String> {
    let hostile = concat!(
        "| |'|''|\"|\\|\\\\\"|(a,b);|[&energy=1]|<!--<script>|]]>|&amp;|--|",
        "->|a\nb|a\r\nb|\t|\0|\u{1b}[2J|\u{7f}|\u{9b}31m|\u{202e}cba|\u{fffe}|1|-1.5e3|NaN|",
        "inf|0x10|true|null|שלום|مرحبا|👩🏽‍🚀|\u{feff}|#|=1+1|a;b|{}|$(reboot)",
    );
    let hostile: Vec<&str> = hostile.split('|').collect();
    prop_oneof![
        proptest::sample::select(hostile.clone()).prop_map(str::to_owned),
        any::<String>(),
        proptest::collection::vec(proptest::sample::select(hostile.clone()), 0..4)
            .prop_map(|parts| parts.concat()),
    ]
}

/// The quoted labels of a Newick text in order, where a doubled quote means one quote.
fn newick_labels(text: &str) -> Vec<String> {
    let (mut labels, mut letters) = (Vec::new(), text.chars().peekable());
    while let Some(letter) = letters.next() {
        if letter != '\'' {
            assert!(!letter.is_control() || letter == '\n', "outside of labels");
            continue;
        }
        let mut label = String::new();
        loop {
            match letters.next().expect("a label ends") {
                '\'' if letters.peek() == Some(&'\'') => {
                    letters.next();
                    label.push('\'');
                }
                '\'' => break,
                letter => label.push(letter),
            }
        }
        labels.push(label);
    }
    labels
}

/// The values of the attribute `label` in a DOT text, by the rules of its quoted strings.
fn dot_labels(text: &str) -> Vec<String> {
    let starts = text
        .match_indices("[label=\"")
        .map(|(start, key)| start + key.len());
    starts
        .map(|start| {
            let (mut label, mut letters) = (String::new(), text[start..].chars());
            loop {
                match letters.next().expect("a label ends") {
                    '\\' => label.push(match letters.next().expect("an escape has a letter") {
                        'n' => '\n',
                        letter => letter,
                    }),
                    '"' => return label,
                    letter => label.push(letter),
                }
            }
        })
        .collect()
}

/// The part of a name that an XML 1.0 document can contain.
fn in_xml(name: &str) -> String {
    name.replace(
        |c: char| {
            (c < ' ' && !matches!(c, '\t' | '\n' | '\r')) || matches!(c, '\u{fffe}' | '\u{ffff}')
        },
        "\u{fffd}",
    )
}

fn commands(c: char) -> bool {
    c.is_control() || ('\u{202a}'..='\u{202e}').contains(&c)
}

proptest! {
    #[test]
    fn names_come_back_from_every_format(names in [any_name(), any_name(), any_name()]) {
        let network = network();
        let tree = Tree::from_network(&network, Evidence::Chain);
        let name = |id: MinimumId| names[id.0].clone();
        let mut sorted = names.to_vec();
        sorted.sort_unstable();

        let mut labels = newick_labels(&newick(&tree, &[], name));
        labels.sort_unstable();
        prop_assert_eq!(&labels, &sorted);

        let text = dot(&tree, &[], name);
        prop_assert!(!text.contains(|c: char| commands(c) && c != '\n'));
        // A name may itself look like an attribute, so only as many as there are leaves are surely theirs.
        if names.iter().all(|name| !name.contains("[label=")) {
            let shown: Vec<String> = (names.iter())
                .map(|name| name.replace(|c: char| commands(c) && c != '\n', "\u{fffd}"))
                .collect();
            let labels = dot_labels(&text);
            // Some further characters that command nothing on a screen are replaced, too.
            for (label, shown) in labels.iter().zip(&shown) {
                let replaced = |text: &str| text.replace(['\u{2028}', '\u{2029}', '\u{2066}', '\u{2067}', '\u{2068}', '\u{2069}', '\u{fffe}', '\u{ffff}'], "\u{fffd}");
                prop_assert_eq!(label, &replaced(shown));
            }
        }

        let json: serde_json::Value = serde_json::from_str(&tree_json(&tree, &[], name)).unwrap();
        for (k, name) in names.iter().enumerate() {
            prop_assert_eq!(json["nodes"][k]["name"].as_str(), Some(name.as_str()));
        }

        let text = graphml(&network, &[], name);
        let document = roxmltree::Document::parse(&text).unwrap();
        let found: Vec<String> = (document.descendants())
            .filter(|node| node.has_tag_name("data") && node.attribute("key") == Some("name"))
            .map(|node| node.text().unwrap_or_default().to_owned())
            .collect();
        prop_assert_eq!(found, names.each_ref().map(|name| in_xml(name)));
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn pictures_are_documents_whatever_they_say(names in [any_name(), any_name(), any_name()]) {
        let network = network();
        let tree = Tree::from_network(&network, Evidence::Chain);
        let mut pictures = (DisconnectivityPicture::new(tree, &network), BarrierPicture::new(&network));
        pictures.0.title.clone_from(&names[0]);
        pictures.1.title.clone_from(&names[0]);
        for (k, name) in names.iter().enumerate() {
            pictures.0.leaves[k].label = Some(name.clone());
            pictures.1.leaves[k].caption = Some(name.clone());
        }
        for canvas in [pictures.0.draw().unwrap(), pictures.1.draw().unwrap()] {
            let svg = canvas.to_svg().unwrap();
            prop_assert!(!svg.contains(|c: char| commands(c) && c != '\n'), "{svg:?}");
            let document = roxmltree::Document::parse(&svg).unwrap();
            let said: Vec<&str> = document.descendants().filter_map(|node| node.text()).collect();
            if names[1].chars().all(|c| c.is_alphanumeric() || "<&\"'>".contains(c)) && !names[1].is_empty() {
                prop_assert!(said.iter().any(|text| text.trim() == names[1]), "{said:?}");
            }
        }
    }
}

/// A folder, a field of a table and an argument that would clear the screen.
#[cfg(unix)]
#[test]
fn a_terminal_gets_no_commands_from_files() {
    let desk = Desk::empty();
    let evil = "p\u{1b}[2J\u{9b}31m\u{202e}";
    desk.database(evil, "0 1.0\n1 1.5\n", "0 1 \u{1b}]0;owned\u{7}\n");
    let harmless = |text: &str| !text.contains(|c: char| commands(c) && c != '\n' && c != '\t');
    let said = desk.mistake(&format!("import {evil}"));
    assert!(
        said.contains("ts.data, line 1, field 3") && harmless(&said),
        "{said:?}"
    );
    desk.database(evil, "0 1.0\n1 1.5\n", "0 1 2\n");
    let output = desk.run(&format!("import {evil} -o out"));
    assert!(output.status.success());
    for text in [output.stdout, output.stderr] {
        let text = String::from_utf8(text).unwrap();
        assert!(!text.is_empty() && harmless(&text), "{text:?}");
    }
    let summary = desk.text("out/summary.md");
    assert!(
        summary.contains("p\u{fffd}[2J") && harmless(&summary),
        "{summary:?}"
    );
    for picture in ["disconnectivity", "barriers"] {
        let svg = desk.text(&format!("out/{picture}.svg"));
        roxmltree::Document::parse(&svg).unwrap();
        assert!(harmless(&svg));
    }
    let said = desk.run(&format!("import x --{evil}"));
    assert!(harmless(&String::from_utf8(said.stderr).unwrap()));
}
