//! The pages: their links lead somewhere, their examples run, and the site has all of them.

use std::collections::BTreeSet;
use std::env;
use std::error::Error;
use std::ffi::OsString;
use std::fs;
use std::path::{Component, Path, PathBuf};
use std::process::Command;

use crate::desk::Desk;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn read(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// The pages below a folder, relative to the project.
fn add_pages(folder: &Path, pages: &mut BTreeSet<PathBuf>) {
    for entry in fs::read_dir(root().join(folder)).unwrap() {
        let name = entry.unwrap().file_name();
        let path = folder.join(&name);
        let hidden =
            name.to_string_lossy().starts_with('.') || name == "target" || name == "node_modules";
        // Landscapes that somebody made here have pages, too.
        let made = path.extension().is_some_and(|ending| ending == "landscape");
        if root().join(&path).is_dir() {
            if !hidden && !made && name != "dist" && name != "wheels" {
                add_pages(&path, pages);
            }
        } else if path.extension().is_some_and(|ending| ending == "md") {
            pages.insert(path);
        }
    }
}

fn pages() -> BTreeSet<PathBuf> {
    let mut pages = BTreeSet::new();
    add_pages(Path::new(""), &mut pages);
    pages
}

/// The lines of a page that are no code.
fn prose(page: &str) -> impl Iterator<Item = &str> {
    let mut code = false;
    page.lines().filter(move |line| {
        let fence = line.trim_start().starts_with("```");
        code ^= fence;
        !code && !fence
    })
}

/// The targets of the links and pictures of a page.
fn targets(page: &str) -> Vec<&str> {
    let of_line = |line| str::split(line, "](").skip(1);
    let targets = prose(page).flat_map(of_line);
    targets
        .filter_map(|rest| rest.split_once(')').map(|(target, _)| target))
        .filter(|target| !target.contains("://"))
        .collect()
}

/// The names by which links reach the headings of a page, as GitHub makes them.
fn anchors(page: &str) -> BTreeSet<String> {
    let headings = prose(page).filter(|line| line.starts_with('#'));
    headings
        .map(|line| {
            let words = line.trim_start_matches('#').trim().to_lowercase();
            let letters = words.chars().filter_map(|letter| match letter {
                ' ' => Some('-'),
                '-' | '_' => Some(letter),
                _ => letter.is_alphanumeric().then_some(letter),
            });
            letters.collect()
        })
        .collect()
}

/// A path without `..`.
fn plain(path: &Path) -> PathBuf {
    let mut plain = PathBuf::new();
    for part in path.components() {
        if part == Component::ParentDir {
            plain.pop();
        } else {
            plain.push(part);
        }
    }
    plain
}

/// What a link leads to, and the heading there.
fn target(page: &Path, link: &str) -> (PathBuf, Option<String>) {
    let (path, heading) = match link.split_once('#') {
        Some((path, heading)) => (path, Some(heading.to_owned())),
        None => (link, None),
    };
    if path.is_empty() {
        return (page.to_path_buf(), heading);
    }
    let folder = page.parent().unwrap_or_else(|| Path::new(""));
    (plain(&folder.join(path)), heading)
}

#[test]
fn links_lead_somewhere() {
    let mut dead = Vec::new();
    for page in pages() {
        let text = read(&root().join(&page));
        for link in targets(&text) {
            let (path, heading) = target(&page, link);
            let file = root().join(&path);
            let there = file.exists()
                && heading.is_none_or(|heading| {
                    path.extension().is_none_or(|ending| ending != "md")
                        || anchors(&read(&file)).contains(&heading)
                });
            if !there {
                dead.push(format!("{}: {link}", page.display()));
            }
        }
    }
    assert!(dead.is_empty(), "{}", dead.join("\n"));
}

#[test]
fn the_site_has_every_page_of_docs() {
    let summary = Path::new("docs/SUMMARY.md");
    let text = read(&root().join(summary));
    let listed: BTreeSet<PathBuf> = targets(&text)
        .into_iter()
        .map(|link| target(summary, link).0)
        .collect();
    let missing: Vec<PathBuf> = pages()
        .into_iter()
        .filter(|page| page.starts_with("docs") && page != summary && !listed.contains(page))
        .collect();
    assert!(missing.is_empty(), "docs/SUMMARY.md lacks {missing:?}");
}

#[test]
fn the_readme_takes_two_minutes() {
    let words = read(&root().join("README.md")).split_whitespace().count();
    assert!(words <= 700, "{words} words");
}

#[test]
fn wrong_links_are_found() {
    let page =
        "# A b–c, *d*\n[x](y.md#z) ![p](../q.png) [w](https://e.org)\n```\n# no\n[n](n.md)\n```\n";
    assert_eq!(targets(page), ["y.md#z", "../q.png"]);
    assert_eq!(anchors(page), BTreeSet::from(["a-bc-d".to_owned()]));
    let here = Path::new("docs/decisions/x.md");
    let there = (PathBuf::from("docs/y.md"), Some("z".to_owned()));
    assert_eq!(target(here, "../y.md#z"), there);
}

/// The blocks of code of a language.
fn blocks(page: &str, language: &str) -> Vec<String> {
    let fence = format!("```{language}\n");
    let parts = page.split(&fence).skip(1);
    parts
        .map(|part| part.split("```").next().unwrap().to_owned())
        .collect()
}

#[test]
fn the_example_of_the_readme_runs() -> Result<(), Box<dyn Error>> {
    // The README shows this:
    use landscape::energy::InBox;
    use landscape::topography::{Run, SearchSettings, explore, in_box};

    let wells = InBox::new(&[-2.0], &[2.0], |x, slope| {
        slope[0] = 4.0 * x[0] * (x[0] * x[0] - 1.0);
        (x[0] * x[0] - 1.0).powi(2)
    });
    let (low, high) = wells.region();
    let draw = in_box(&low, &high);
    let settings = SearchSettings::measured(&wells, &draw, 0);
    let found = explore(&wells, &draw, &settings, &Run::default())?;
    assert_eq!(found.minima.len(), 2);
    // To here.
    let source = include_str!("pages.rs");
    let (_, rest) = source.split_once("// The README shows this:\n").unwrap();
    let (code, _) = rest.split_once("    // To here.\n").unwrap();
    let code: String = code
        .lines()
        .map(|line| line.strip_prefix("    ").unwrap_or(line).to_owned() + "\n")
        .collect();
    assert_eq!(blocks(&read(&root().join("README.md")), "rust"), [code]);
    Ok(())
}

/// Copies a folder.
fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap() {
        let entry = entry.unwrap();
        let target = to.join(entry.file_name());
        let made = (target.extension()).is_some_and(|ending| ending == "landscape");
        if !entry.path().is_dir() {
            fs::copy(entry.path(), target).unwrap();
        } else if !made {
            copy(&entry.path(), &target);
        }
    }
}

/// Runs the commands of a tutorial in a folder that has the files of the project which they name.
#[cfg(unix)]
fn follow(tutorial: &str, makes: &[&str]) -> Desk {
    let desk = Desk::empty();
    for folder in ["data", "python/tutorials/claw"] {
        copy(&root().join(folder), &desk.path(folder));
    }
    let program = Path::new(env!("CARGO_BIN_EXE_landscape"));
    let mut path = OsString::from(program.parent().unwrap());
    if let Some(rest) = env::var_os("PATH") {
        path.push(":");
        path.push(rest);
    }
    let python = Command::new("python3").arg("--version").output().is_ok();
    let commands = blocks(&read(&root().join("docs/tutorials").join(tutorial)), "sh");
    assert!(!commands.is_empty(), "{tutorial} has no commands");
    for command in commands {
        if command.contains("python3") && !python {
            crate::skipped::skipped("there is no python3");
            continue;
        }
        let run = Command::new("sh")
            .args(["-e", "-c", &command])
            .current_dir(desk.folder.path())
            .env("PATH", &path)
            .output()
            .unwrap();
        let said = String::from_utf8_lossy(&run.stderr);
        assert!(run.status.success(), "{tutorial}: {command}{said}");
    }
    for made in makes {
        assert!(desk.path(made).exists(), "{tutorial} makes no {made}");
    }
    desk
}

#[cfg(unix)]
#[test]
fn the_tutorial_of_hands_runs() {
    follow(
        "own_hand.md",
        &[
            "claw.png",
            "claw.grasps.html",
            "claw.landscape/report.html",
            "claw.diversity.md",
        ],
    );
}

#[cfg(unix)]
#[test]
fn the_tutorial_of_published_grasps_runs() {
    follow(
        "published_grasps.md",
        &[
            "published.stability.parquet",
            "published.labelled.parquet",
            "published.landscape/report.html",
            "published_qpos.csv",
        ],
    );
}

#[cfg(unix)]
#[test]
fn the_tutorial_of_judging_runs() {
    let made = [
        "set.judge.md",
        "set.judge.grasps.csv",
        "two.png",
        "judged.parquet",
    ];
    let desk = follow("judge_data_set.md", &made);
    assert!(read(&desk.path("two.md")).contains("| dexgraspbench |"));
}

#[cfg(unix)]
#[test]
fn the_tutorial_of_gaps_runs() {
    let made = [
        "asked.parquet",
        "repaired.parquet",
        "pen.png",
        "filled.survey",
    ];
    let desk = follow("fill_the_gaps.md", &made);
    // The summaries list the types that are missing.
    let lacks = |survey: &str| read(&desk.path(survey)).contains("Quadpod");
    assert!(lacks("set.survey/summary.md"));
    assert!(!lacks("filled.survey/summary.md"));
}

#[cfg(unix)]
#[test]
fn the_tutorial_of_energies_runs() {
    let made = ["min.data", "ts.data", "tree.nwk", "report.html"];
    let made = made.map(|name| format!("lj-7.landscape/{name}"));
    let desk = follow("own_energy.md", &made.each_ref().map(String::as_str));
    let summary = read(&desk.path("lj-7.landscape/summary.md"));
    assert!(summary.contains("**4 minima** and **12 saddles**"));
}

#[cfg(unix)]
#[test]
fn the_tutorial_of_dihedral_angles_runs() {
    let desk = follow("pentane.md", &[]);
    let summary = desk.path("pentane.landscape/summary.md");
    // Without python3 the command was skipped.
    if summary.exists() {
        let summary = read(&summary);
        assert!(summary.contains("**9 minima** and **18 saddles**"));
        for line in [
            "| m0 | -0.407001 |",
            "| m8 | 16.373267 | 17.130712 |",
            "| 31.963916 |",
        ] {
            assert!(summary.contains(line), "{line}");
        }
    }
}

#[cfg(unix)]
#[test]
fn the_tutorial_of_measures_runs() {
    let made = [
        "lj-7.thermodynamics/superbasins.csv",
        "lj-7.view/disconnectivity.svg",
        "muller-brown.view/disconnectivity.svg",
    ];
    let desk = follow("measures.md", &made);
    let summary = read(&desk.path("lj-7.thermodynamics/summary.md"));
    assert!(summary.contains("Their asymmetry (difference of these, divided by the sum) is 0.37."));
}

/// The commands of the README are those of the program: each says what is missing here, and nothing about its arguments.
#[test]
fn commands_of_the_readme_are_understood() {
    let page = read(&root().join("README.md"));
    let blocks = blocks(&page, "sh");
    let desk = Desk::empty();
    let mut understood = 0;
    for line in blocks.iter().flat_map(|block| block.lines()) {
        let line = line.split('#').next().unwrap();
        let arguments = line
            .trim()
            .strip_prefix("landscape ")
            .or_else(|| line.trim().strip_prefix("cargo run --release -- "));
        if let Some(arguments) = arguments {
            desk.mistake(arguments);
            understood += 1;
        }
    }
    assert!(understood >= 4, "{blocks:#?}");
}
