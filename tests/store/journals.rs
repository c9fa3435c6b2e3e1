//! Journals keep their complete records after any truncation or damage.

use std::fs;
use std::path::Path;

use crate::store::{flipped, place, sentence};
use landscape::store::{Journal, StoreError};

#[test]
fn a_journal_remembers() {
    let (_folder, path) = place("journal");
    let journal = Journal::open(&path, "input 1", false).unwrap();
    assert!(journal.is_empty());
    journal.put("quench 0", b"one").unwrap();
    journal.put("", &[]).unwrap();
    journal.put("quench 0", b"two").unwrap();
    std::thread::scope(|scope| {
        for thread in 0..4_u32 {
            let journal = &journal;
            scope.spawn(move || {
                for task in 0..50_u32 {
                    journal
                        .put(&format!("{thread} {task}"), &(thread * task).to_le_bytes())
                        .unwrap();
                }
            });
        }
    });
    journal.sync().unwrap();
    assert!(matches!(
        Journal::open(&path, "input 1", false),
        Err(StoreError::InUse { .. })
    ));
    drop(journal);

    let journal = Journal::open(&path, "input 1", false).unwrap();
    assert_eq!((journal.len(), journal.dropped_bytes()), (202, 0));
    assert_eq!(journal.get("quench 0").unwrap(), b"two");
    assert_eq!(journal.get("").unwrap(), b"");
    assert_eq!(journal.get("3 49").unwrap(), 147_u32.to_le_bytes());
    assert_eq!(journal.get("quench 1"), None);
    journal.remove().unwrap();
    assert!(!path.exists());
}

#[test]
fn a_journal_of_other_input_is_refused() {
    let (folder, path) = place("journal");
    Journal::open(&path, "input 1", false)
        .unwrap()
        .put("a", b"1")
        .unwrap();
    for other in ["input 2", "", "input 11"] {
        let refused = Journal::open(&path, other, false).unwrap_err();
        assert_eq!(
            sentence(&refused, folder.path()),
            "journal belongs to a run with other input or settings, or of another version of the program: repeat those \
             to resume it, or start over with --fresh"
        );
    }
    assert_eq!(
        Journal::open(&path, "input 1", false)
            .unwrap()
            .get("a")
            .unwrap(),
        b"1"
    );
    assert_eq!(
        Journal::open(&path, "input 2", true).unwrap().get("a"),
        None
    );
    assert!(Journal::open(&path, "input 2", false).unwrap().is_empty());

    fs::write(&path, "something else entirely").unwrap();
    let refused = Journal::open(&path, "input 1", false).unwrap_err();
    assert_eq!(
        sentence(&refused, folder.path()),
        "journal is not a journal of this program or its head is damaged: start over with --fresh"
    );
    assert_eq!(
        fs::read_to_string(&path).unwrap(),
        "something else entirely"
    );
    assert!(Journal::open(&path.join("x"), "input 1", false).is_err());
}

/// A journal with three records, and the ends of its parts: head, first, second, third.
fn three_records(path: &Path) -> (Vec<u8>, [usize; 4]) {
    let journal = Journal::open(path, "input", true).unwrap();
    let mut ends = [length(path); 4];
    for (task, payload) in [b"first payload".as_slice(), &[0; 20], b"third"]
        .into_iter()
        .enumerate()
    {
        journal.put(&format!("task {task}"), payload).unwrap();
        ends[task + 1] = length(path);
    }
    (fs::read(path).unwrap(), ends)
}

fn length(path: &Path) -> usize {
    usize::try_from(fs::metadata(path).unwrap().len()).unwrap()
}

#[test]
fn a_journal_cut_anywhere_keeps_every_whole_record_and_goes_on() {
    let (_folder, path) = place("journal");
    let (whole, ends) = three_records(&path);
    for cut in 0..=whole.len() {
        fs::write(&path, &whole[..cut]).unwrap();
        let journal = Journal::open(&path, "input", false).unwrap();
        let kept = ends[1..].iter().filter(|end| **end <= cut).count();
        assert_eq!(journal.len(), kept, "cut at {cut}");
        let kept_end = if cut < ends[0] { 0 } else { ends[kept] };
        assert_eq!(
            journal.dropped_bytes(),
            (cut - kept_end) as u64,
            "cut at {cut}"
        );
        // The tasks that were lost are done again.
        for (task, payload) in [b"first payload".as_slice(), &[0; 20], b"third"]
            .into_iter()
            .enumerate()
            .skip(kept)
        {
            journal.put(&format!("task {task}"), payload).unwrap();
        }
        drop(journal);
        assert_eq!(fs::read(&path).unwrap(), whole, "cut at {cut}");
    }
}

/// A power cut may leave blocks of zeros, or a tail with wrong bytes in it.
#[test]
fn a_journal_with_a_spoilt_last_record_drops_it() {
    let (_folder, path) = place("journal");
    let (whole, ends) = three_records(&path);
    for position in ends[2]..ends[3] {
        for mask in [0x01, 0x80, 0xff] {
            fs::write(&path, flipped(&whole, position, mask)).unwrap();
            let journal = Journal::open(&path, "input", false).unwrap();
            assert_eq!(
                (journal.len(), length(&path)),
                (2, ends[2]),
                "byte {position}"
            );
        }
        let mut zeros = whole[..position].to_vec();
        zeros.resize(whole.len() + 100, 0);
        fs::write(&path, zeros).unwrap();
        assert_eq!(
            Journal::open(&path, "input", false).unwrap().len(),
            2,
            "zeros from byte {position}"
        );
    }
    for position in 0..ends[0] {
        // A damaged length of the head must not pass for a head cut off, which would cost the records.
        let spoilt = flipped(&whole, position, 0xff);
        fs::write(&path, &spoilt).unwrap();
        let opened = Journal::open(&path, "input", false);
        assert!(
            matches!(opened, Err(StoreError::NotAJournal { .. })),
            "head byte {position}: {opened:?}"
        );
        assert_eq!(fs::read(&path).unwrap(), spoilt, "nothing is destroyed");
    }
}
