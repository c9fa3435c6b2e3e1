//! Files and folders are written completely or not at all, even if the process is killed.

use std::fs;
use std::path::Path;

use crate::store::{landscape, names, place, sentence};
use landscape::store::{AtomicFolder, FileSet, Journal, LandscapeFiles, StoreError};
use serde_json::json;

#[test]
fn a_folder_takes_its_name_when_it_is_complete() {
    let (folder, path) = place("cup.landscape");
    let partial = folder.path().join("cup.landscape.partial");
    let unfinished = AtomicFolder::open(&path, false).unwrap();
    assert_eq!(unfinished.path(), partial);
    unfinished.write("tree.nwk", b"();").unwrap();
    let refused = unfinished.finish().unwrap_err();
    assert!(
        matches!(refused, StoreError::Unfinished { .. }),
        "no manifest, no landscape"
    );
    assert_eq!(names(folder.path()), ["cup.landscape.partial"]);

    // Resumed: what was half made is made again, the journal is kept.
    fs::write(partial.join("journal"), "kept").unwrap();
    let resumed = AtomicFolder::open(&path, false).unwrap();
    assert_eq!(names(&partial), [".unfinished", "journal"]);
    landscape().write(&resumed).unwrap();
    resumed.finish().unwrap();
    assert_eq!(names(folder.path()), ["cup.landscape"]);

    // While the next one grows, the old one stays.
    let next = AtomicFolder::open(&path, false).unwrap();
    next.write("extra", b"1").unwrap();
    assert_eq!(LandscapeFiles::read(&path).unwrap(), landscape());
    let mut changed = landscape();
    changed.manifest.seed = 8;
    changed.write(&next).unwrap();
    next.finish().unwrap();
    assert_eq!(LandscapeFiles::read(&path).unwrap(), changed);
    assert_eq!(names(folder.path()), ["cup.landscape"]);

    fs::create_dir(&partial).unwrap();
    fs::write(partial.join(".unfinished"), "").unwrap();
    fs::write(partial.join("journal"), "not kept").unwrap();
    AtomicFolder::open(&path, true).unwrap();
    assert_eq!(
        names(&partial),
        [".unfinished"],
        "a fresh start keeps nothing"
    );
}

/// The state of the disk after each step of `finish`, as a killed run leaves it.
#[test]
fn a_folder_survives_being_killed_between_renames() {
    let complete = |path: &Path, seed: u64| {
        fs::create_dir(path).unwrap();
        let json = json!({ "format": "landscape", "seed": seed });
        fs::write(path.join("landscape.json"), json.to_string()).unwrap();
        fs::write(path.join(".unfinished"), "").unwrap();
        fs::write(path.join("journal"), "tasks").unwrap();
    };
    let seed = |path: &Path| {
        let text = fs::read_to_string(path.join("landscape.json")).unwrap();
        serde_json::from_str::<serde_json::Value>(&text).unwrap()["seed"].clone()
    };
    let (folder, path) = place("cup.landscape");
    let [partial, old] =
        [".partial", ".old.partial"].map(|end| folder.path().join(format!("cup.landscape{end}")));

    complete(&old, 1);
    complete(&partial, 2);
    AtomicFolder::open(&path, false).unwrap();
    assert_eq!(seed(&path), 1, "the previous landscape is back");
    assert_eq!(
        names(&partial),
        [".unfinished", "journal"],
        "and the work of the next is kept"
    );
    assert!(!old.exists());

    fs::remove_dir_all(&partial).unwrap();
    complete(&old, 0);
    AtomicFolder::open(&path, false).unwrap();
    assert_eq!(seed(&path), 1, "the new landscape stays");
    assert!(!old.exists());

    // After the last renaming, before the journal was removed.
    fs::remove_dir_all(&partial).unwrap();
    fs::write(path.join("journal"), "all tasks").unwrap();
    assert_eq!(
        AtomicFolder::left_journal(&path),
        Some(path.join("journal"))
    );
    AtomicFolder::open(&path, false).unwrap();
    assert_eq!(
        fs::read_to_string(partial.join("journal")).unwrap(),
        "all tasks"
    );
    assert!(!path.join("journal").exists());

    // While the previous folder was removed: what shows that it is ours goes last.
    fs::create_dir(&old).unwrap();
    fs::write(old.join("landscape.json"), r#"{"format": "landscape"}"#).unwrap();
    AtomicFolder::open(&path, false).unwrap();
    assert!(!old.exists());

    // While the first file of all was written.
    fs::remove_dir_all(&partial).unwrap();
    assert_eq!(AtomicFolder::left_journal(&path), None);
    fs::create_dir(&partial).unwrap();
    fs::write(partial.join(".unfinished.123.partial"), "land").unwrap();
    AtomicFolder::open(&path, false).unwrap();
    assert_eq!(names(&partial), [".unfinished"]);
}

/// Neither continuing a run nor beginning anew removes the files of a running process.
#[test]
fn a_folder_in_use_is_left_alone() {
    let (folder, path) = place("cup.landscape");
    let unfinished = AtomicFolder::open(&path, false).unwrap();
    let journal = Journal::open(&unfinished.journal(), "input", false).unwrap();
    journal.put("task", b"done").unwrap();
    unfinished.write("tree.nwk", b"();").unwrap();
    for fresh in [false, true] {
        let refused = AtomicFolder::open(&path, fresh).unwrap_err();
        assert_eq!(
            sentence(&refused, folder.path()),
            "another process is writing cup.landscape: wait until it ends, or name another output"
        );
        assert_eq!(
            names(unfinished.path()),
            [".unfinished", "journal", "tree.nwk"]
        );
    }
    landscape().write(&unfinished).unwrap();
    unfinished.finish().unwrap();
    assert_eq!(names(folder.path()), ["cup.landscape"]);
    assert!(!path.join("journal").exists());
}

#[test]
fn of_a_set_all_files_appear_or_none() {
    let (folder, path) = place("a.csv");
    fs::create_dir(folder.path().join("taken")).unwrap();
    let mut set = FileSet::default();
    set.add(&path, b"a").unwrap();
    set.add(&folder.path().join("absent/b.csv"), b"b")
        .unwrap_err();
    let taken = set.add(&folder.path().join("taken"), b"b").unwrap_err();
    assert!(matches!(taken, StoreError::NotOurs { .. }));
    assert!(!path.exists(), "not before the whole set is written");
    drop(set);
    assert_eq!(names(folder.path()), ["taken"]);

    let mut set = FileSet::default();
    set.add(&path, b"a").unwrap();
    set.add(&folder.path().join("b.csv"), b"b").unwrap();
    set.finish().unwrap();
    assert_eq!(names(folder.path()), ["a.csv", "b.csv", "taken"]);
}

#[test]
fn what_others_made_is_never_removed() {
    for name in [
        "cup.landscape",
        "cup.landscape.partial",
        "cup.landscape.old.partial",
    ] {
        let (folder, path) = place("cup.landscape");
        let foreign = folder.path().join(name);
        fs::create_dir(&foreign).unwrap();
        fs::write(foreign.join("thesis.tex"), "years").unwrap();
        fs::write(foreign.join("landscape.json"), r#"{"format": "painting"}"#).unwrap();
        for fresh in [false, true] {
            let refused = AtomicFolder::open(&path, fresh).unwrap_err();
            let expected = format!(
                "{name} exists and was not made by landscape: move it away or choose another name"
            );
            assert_eq!(sentence(&refused, folder.path()), expected);
        }
        assert_eq!(names(&foreign), ["landscape.json", "thesis.tex"]);
        assert_eq!(names(folder.path()), [name]);
    }
    let (folder, path) = place("cup.landscape");
    let folder_in_time = AtomicFolder::open(&path, false).unwrap();
    landscape().write(&folder_in_time).unwrap();
    fs::write(&path, "a file that came while we worked").unwrap();
    assert!(matches!(
        folder_in_time.finish(),
        Err(StoreError::NotOurs { .. })
    ));
    assert_eq!(
        names(folder.path()),
        ["cup.landscape", "cup.landscape.partial"]
    );
    let refused =
        AtomicFolder::open(&folder.path().join("absent/cup.landscape"), false).unwrap_err();
    assert_eq!(
        sentence(&refused, folder.path()),
        "cannot create absent/cup.landscape.partial"
    );
}
