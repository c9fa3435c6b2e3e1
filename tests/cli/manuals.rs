//! Scripts for shells and manual pages know every command and every flag.

use std::process::Command;

use crate::desk::Desk;
use crate::names;

/// Bash completes commands, flags and values.
#[cfg(unix)]
#[test]
fn bash_completes_what_was_begun() {
    let desk = Desk::empty();
    let output = desk.run("completions bash");
    assert!(output.status.success());
    desk.write("landscape.bash", output.stdout);
    for (words, expected) in [
        ("landscape sta", "stability"),
        ("landscape synth --spr", "--spread"),
        ("landscape synth --keep pu", "published"),
        ("landscape objects ba", "bake"),
        ("landscape completions fi", "fish"),
    ] {
        let count = words.split(' ').count() - 1;
        let script = format!(
            "source landscape.bash; COMP_WORDS=({words}); COMP_CWORD={count}; \
             _landscape landscape \"${{COMP_WORDS[{count}]}}\" \"${{COMP_WORDS[{}]}}\"; echo \"${{COMPREPLY[@]}}\"",
            count - 1
        );
        let output = Command::new("bash")
            .args(["-c", &script])
            .current_dir(desk.folder.path())
            .output()
            .unwrap();
        let told = String::from_utf8_lossy(&output.stdout);
        let found = told.split_whitespace().any(|word| word == expected);
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(found, "{words}: {told} {said}");
    }
    for shell in ["zsh", "fish", "elvish", "powershell"] {
        let script = desk.print(&format!("completions {shell}"));
        for word in ["stability", "completions", "spread", "no-report"] {
            assert!(script.contains(word), "{shell}: {word}");
        }
    }
}

/// Each command has its page, which names all its flags.
#[test]
fn every_command_has_a_page() {
    let desk = Desk::empty();
    desk.succeed("man pages -q");
    let mut expected = Vec::new();
    let mut open = vec![("landscape".to_owned(), landscape::cli::definition())];
    while let Some((name, command)) = open.pop() {
        let page = desk.text(&format!("pages/{name}.1"));
        // Hyphens are escaped.
        let page = page.replace("\\-", "-");
        assert!(page.contains(&format!("{name} -")), "{name}");
        for flag in command.get_arguments().filter_map(|flag| flag.get_long()) {
            assert!(page.contains(&format!("--{flag}")), "{name}: --{flag}");
        }
        for under in command
            .get_subcommands()
            .filter(|under| under.get_name() != "help")
        {
            open.push((format!("{name}-{}", under.get_name()), under.clone()));
        }
        expected.push(format!("{name}.1"));
    }
    expected.sort();
    let mut found = names(&desk.path("pages"));
    found.sort();
    assert_eq!(found, expected);
    // The same pages are written again, but nothing of others.
    desk.succeed("man pages -q");
    desk.write("pages/thesis.tex", "years of work");
    let sentence = desk.early_mistake("man pages");
    assert!(sentence.contains("thesis.tex"), "{sentence}");
}
