//! Files that cannot be imported: every mistake is told in one sentence.

use std::fs;

use super::{TABLE, with_table};
use crate::desk::assert_says;
use crate::pickled::bench;
use crate::table::rows;
use landscape::store::exchange::{Mapping, read};

#[test]
fn mistakes_are_one_sentence() {
    let desk = with_table();
    let write = |name: &str, bytes: &[u8]| desk.write(name, bytes);
    write(
        "system.npy",
        &npy(b"\x80\x03cos\nsystem\nX\x0b\x00\x00\x00touch owned\x85R."),
    );
    write("cut.npy", &bench()[0][..400]);
    write("whole.npy", &bench()[0]);
    write("words.npy", b"words");
    write("other.npy", &npy(b"\x80\x03}X\x01\x00\x00\x00aK\x01s."));
    write("nan.csv", TABLE.replace("0.011", "NaN").as_bytes());
    write("word.csv", TABLE.replace("0.011", "left").as_bytes());
    write("long.csv", TABLE.replace("0.6,0.0", "0.9,0.0").as_bytes());
    write("ragged.csv", TABLE.replace("0.6,0.0", "0.6").as_bytes());
    write(
        "far.csv",
        TABLE
            .replace("0.025", "25")
            .replace("0.0301234567890123", "30")
            .replace("0.0401", "40")
            .as_bytes(),
    );
    write("other.csv", TABLE.replace("jaw", "thumb").as_bytes());
    write("empty.csv", TABLE.lines().next().unwrap().as_bytes());
    write("bad.json", b"[1, 2");
    write("odd.toml", b"rotation_form = \"roll\"");
    write("typo.toml", b"rotations = \"q\"");
    write("a.npz", b"PK\x03\x04......pose.npy");
    write("i.yaml", b"format: isaac_grasp\nformat_version: \"1.0\"\n");
    write("a.h5", b"\x89HDF\r\n\x1a\n");
    write("a.pt", b"PK\x03\x04......grasps/data.pkl");
    write("old.pt", b"\x80\x02\x8a\nl\xfc\x9cF\xf9 j\xa8P\x19.");
    write("o.yaml", b"format: other\n");
    write(
        "j.yaml",
        b"{format: isaac_grasp, grasps: {a: {position: [0, 0, 0], orientation: {w: 1, xyz: [0, 0, 0]}, cspace_position: {f: 1}}}}",
    );
    write("a.xyz", b"1 2 3");
    write(
        "g.json",
        b"{\"object\": {}, \"grasps\": {\"transforms\": [[[1, 0], [0, 1]]]}}",
    );
    fs::create_dir_all(desk.path("empty")).unwrap();
    fs::create_dir_all(desk.path("data/mug/small")).unwrap();
    write("data/mug/small/0.npy", &bench()[0]);
    write("gone.toml", b"joints = { jaw = \"finger\" }");
    let with = "--hand gripper_parallel --object ball";
    let cases = "
        import system.npy {with} | system.npy | it calls os.system | no code of a pickle is executed
        import cut.npy {with} | cut.npy | cut short
        import words.npy {with} | words.npy | not a .npy file
        import other.npy {with} | neither `qpos` | nor `grasp_qpos`
        import whole.npy --hand human --object ball | 8 numbers | joints of the hand
        import nan.csv {with} | nan.csv | row 1 | translation_m_y | not a finite number
        import word.csv {with} | row 1 | `left` | numbers are needed
        import long.csv {with} | row 1 | quaternion has length
        import ragged.csv {with} | not a valid CSV table
        import far.csv {with} | far.csv: joint `jaw` is at 40 | beyond its limits | probably its joints are in millimetres
        import other.csv {with} | no columns for the joints jaw | mapping
        import empty.csv {with} | contains no grasps
        import bad.json {with} | not valid JSON
        import t.csv {with} --mapping odd.toml | odd.toml | roll
        import t.csv {with} --mapping typo.toml | typo.toml | rotations
        import t.csv {with} --mapping gone.toml | no column `finger`
        import t.csv {with} --scale 0.5 | --scale 0.5 | at 1 (3)
        import t.csv {with} --scale -1 | --scale -1 is not
        import t.csv --object ball | --hand
        import t.csv --hand gripper_parallel | --object
        import t.csv {with} -o t.csv | is an input of this command
        import nowhere {with} | nowhere | no such file or folder
        import empty {with} | empty: contains neither .npy files | min.data
        import data {with} | grasps lie deeper | data/mug/small
        import a.npz {with} | a.npz | numpy.savez | is not read | .csv, .json or .parquet
        import a.npz | a.npz | numpy.savez | is not read
        import i.yaml {with} | i.yaml | `grasps` is not a map
        import o.yaml {with} | o.yaml | `format` is not isaac_grasp | .csv
        import j.yaml {with} | grasp `a` | in the hand but not in the file: jaw | not in the hand: f
        import a.h5 {with} | a.h5 | HDF5 | ACRONYM | is not read
        import a.pt {with} | a.pt | ZIP
        import old.pt {with} | old.pt | not a ZIP file | save it again
        import g.json {with} | g.json | `grasps.transforms` 0 | 4 × 4
        import a.xyz {with} | a.xyz | .xyz is not read
        export t.parquet csv -o t.npy -q | must end in .csv
        export t.parquet glb --grasp 8 -q | has no grasp with this id
        export t.parquet glb -o all.glb -q | contains one grasp
    ";
    for case in rows(cases) {
        let sentence = desk.mistake(&case[0].replace("{with}", with));
        assert_says(&sentence, &case[1..]);
    }
    assert!(!desk.path("owned").exists());
}

/// A file with one pickled object.
fn npy(body: &[u8]) -> Vec<u8> {
    let mut header = b"{'descr': '|O', 'fortran_order': False, 'shape': (), }".to_vec();
    header.resize(117, b' ');
    header.push(b'\n');
    let mut bytes = b"\x93NUMPY\x01\x00\x76\x00".to_vec();
    bytes.extend(header);
    bytes.extend(body);
    bytes
}

/// Values that refer to the same long list, text or bytes, each of which would be made anew.
#[test]
fn a_pickle_cannot_make_much_of_little() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("p.npy");
    let said = |pickle: &[u8]| {
        fs::write(&path, npy(pickle)).unwrap();
        let read = read(&path, &["jaw".to_owned()], &Mapping::default());
        read.unwrap_err().to_string()
    };
    let list = [&b"("[..], &b"K\x01".repeat(3000), b"lq\x00"].concat();
    let bytes = [&b"B\xb8\x0b\x00\x00"[..], &[7; 3000], b"q\x00"].concat();
    let kind = b"cnumpy\ndtype\nX\x02\x00\x00\x00u1\x85Rq\x01";
    let array = b"cnumpy.core.numeric\n_frombuffer\n(h\x00h\x01M\xb8\x0b\x85tR0";
    let filled = b"cnumpy\nndarray\n)R(K\x01M\xb8\x0b\x85h\x01\x89h\x00tb0";
    for (shared, again) in [
        (list, &b"cnumpy\nndarray\nh\x00R0"[..]),
        ([&bytes[..], kind].concat(), &array[..]),
        ([&bytes[..], kind].concat(), &filled[..]),
    ] {
        let pickle = |times: usize| [&shared[..], &again.repeat(times), b"."].concat();
        let once = said(&pickle(1));
        assert!(once.contains("neither `qpos`"), "{once}");
        let often = said(&pickle(300));
        assert!(
            often.contains("far more values than its bytes can describe"),
            "{often}"
        );
    }
    let entries = said(&[&b"}("[..], &b"K\x01N".repeat(2000), b"u."].concat());
    assert!(entries.contains("1024 entries"), "{entries}");
}
