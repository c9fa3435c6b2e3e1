//! Folders of landscapes are restored exactly and written with the same bytes.

use std::fs;

use crate::store::{landscape, names, place, sentence};
use landscape::store::{AtomicFolder, LandscapeFiles, Phase, Timings};

#[test]
fn landscapes_come_back_equal_and_with_the_same_bytes() {
    let (_folder, path) = place("cup.landscape");
    let mut bytes = Vec::new();
    for _ in 0..2 {
        let folder = AtomicFolder::open(&path, false).unwrap();
        landscape().write(&folder).unwrap();
        let phases = vec![Phase {
            name: "quench".into(),
            seconds: 1.5,
            evaluations: 10,
        }];
        let timings = Timings {
            threads: 2,
            phases,
            ..Timings::default()
        };
        timings.write(&folder).unwrap();
        assert_eq!(folder.finish().unwrap(), path);
        assert_eq!(LandscapeFiles::read(&path).unwrap(), landscape());
        let files = names(&path);
        assert_eq!(
            files,
            [
                "edges.parquet",
                "landscape.json",
                "minima.parquet",
                "paths.parquet",
                "timings.json"
            ]
        );
        bytes.push(
            files
                .iter()
                .map(|name| fs::read(path.join(name)).unwrap())
                .collect::<Vec<_>>(),
        );
    }
    assert_eq!(bytes[0], bytes[1]);
}

#[test]
fn a_landscape_may_be_almost_empty_and_must_be_finite() {
    let (_folder, path) = place("cup.landscape");
    let folder = AtomicFolder::open(&path, false).unwrap();
    let empty = LandscapeFiles::default();
    empty.write(&folder).unwrap();
    assert_eq!(
        LandscapeFiles::read(&folder.finish().unwrap()).unwrap(),
        empty
    );

    let folder = AtomicFolder::open(&path, false).unwrap();
    let mut spoilt = landscape();
    spoilt.edges[1].height = Some(f64::INFINITY);
    let refused = spoilt.write(&folder).unwrap_err();
    assert_eq!(
        sentence(&refused, folder.path()),
        "edges.parquet, row 1 (the first is 0): column `height` contains inf, which is not a finite number"
    );
}

#[test]
fn folders_that_are_no_landscapes_are_not_read() {
    let (folder, path) = place("cup.landscape");
    let refusal = || sentence(&LandscapeFiles::read(&path).unwrap_err(), folder.path());
    assert_eq!(refusal(), "no such file: cup.landscape/landscape.json");
    fs::create_dir(&path).unwrap();
    assert_eq!(
        refusal(),
        "cup.landscape contains no finished landscape: landscape.json is missing or comes from another program"
    );
    fs::write(path.join("landscape.json"), "{}").unwrap();
    assert_eq!(
        refusal(),
        "cup.landscape contains no finished landscape: landscape.json is missing or comes from another program"
    );
    fs::write(
        path.join("landscape.json"),
        r#"{"format": "landscape", "schema_version": 2}"#,
    )
    .unwrap();
    assert_eq!(
        refusal(),
        "cup.landscape/landscape.json has schema version 2, but only version 1 is supported"
    );
}
