//! What is kept between runs: objects are cut once, with the same bytes, and `landscape cache` shows and empties the folder.

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::desk::{Desk, assert_says};
use crate::{contents, in_cache};

/// Two boxes that form an L, which is not convex.
const CORNER: &str = "\
[[parts]]
cuboid = { centre = [0, 0, 0], half_extents = [0.03, 0.01, 0.01] }
[[parts]]
cuboid = { centre = [0.02, 0, 0.02], half_extents = [0.01, 0.01, 0.02] }
";

struct Kept {
    desk: Desk,
}

impl Kept {
    /// What a successful command prints, and what it says on standard error.
    fn run(&self, line: &str) -> (String, String) {
        let mut command = self.desk.command(line);
        in_cache(&mut command, &self.desk.path("cache"));
        let output = command.output().unwrap();
        let [told, said] =
            [output.stdout, output.stderr].map(|bytes| String::from_utf8(bytes).unwrap());
        assert!(output.status.success(), "landscape {line}: {said}");
        (told, said)
    }

    fn json(&self, line: &str) -> Value {
        serde_json::from_str(&self.run(&format!("{line} --json")).0).unwrap()
    }

    /// The files with this ending below a folder.
    fn files(&self, ending: &str) -> Vec<PathBuf> {
        let mut folders = vec![self.desk.path("cache")];
        let mut found = Vec::new();
        while let Some(folder) = folders.pop() {
            for entry in fs::read_dir(folder).into_iter().flatten() {
                let path = entry.unwrap().path();
                if path.is_dir() {
                    folders.push(path);
                } else if path.extension().is_some_and(|other| other == ending) {
                    found.push(path);
                }
            }
        }
        found
    }
}

#[test]
fn an_object_is_cut_once_and_the_cache_is_shown_and_emptied() {
    let kept = Kept {
        desk: Desk::empty(),
    };
    kept.desk.write("corner.toml", CORNER);
    kept.run("synth --object corner.toml -n 2 --steps 1 --keep all --drop 0 -q -o g.parquet");
    assert_eq!(
        (kept.files("field").len(), kept.files("pieces").len()),
        (1, 0)
    );

    let exported = |name: &str| {
        kept.run(&format!("export g.parquet mujoco -o {name}"));
        let files = contents(&kept.desk.path(name));
        let names = files.into_iter().map(|(path, bytes)| {
            let name = path.file_name().map(Path::new).map(Path::to_path_buf);
            (name, bytes)
        });
        names.collect::<Vec<_>>()
    };
    let cut = exported("cut");
    let [file] = &kept.files("pieces")[..] else {
        panic!("one cut is kept");
    };
    let bytes = fs::read(file).unwrap();
    let read = exported("read");
    assert!(
        cut.len() > 2 && cut == read,
        "the same bytes from the cache"
    );
    // A simulation needs the same pieces.
    let (told, _) = kept.run("stability g.parquet");
    assert_says(&told, &["pieces", "fall short by (mm)"]);
    assert_eq!(kept.files("pieces").len(), 1);

    // A damaged file is not used, and mended.
    let mut damaged = bytes.clone();
    let middle = damaged.len() / 2;
    damaged[middle] ^= 1;
    fs::write(file, &damaged).unwrap();
    assert!(exported("again") == cut);
    assert!(fs::read(file).unwrap() == bytes);

    let shown = kept.json("cache");
    assert_eq!(
        (&shown["fields"], &shown["cut_objects"]),
        (&1.into(), &1.into())
    );
    assert!(shown["bytes"].as_u64().unwrap() < shown["most_bytes"].as_u64().unwrap());
    assert_says(
        &kept.run("cache").0,
        &["cut objects         1", "greatest size (MB)"],
    );
    let removed = kept.json("cache clear");
    assert_eq!(removed["removed_files"], 2);
    assert_eq!(removed["removed_bytes"], shown["bytes"]);
    assert_eq!(
        (kept.files("field").len(), kept.files("pieces").len()),
        (0, 0)
    );
    assert_says(&kept.run("cache clear").0, &["removed files  0"]);
    assert!(exported("anew") == cut);
}
