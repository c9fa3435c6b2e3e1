//! Valid files of every format.

use std::fs;
use std::io::{Cursor, Write};
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use super::pickled::{self, Tensors, torch_of};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use bytes::Bytes;
use landscape::evaluation::taxonomy::{Example, Taught, UNLISTED_CLASS};
use landscape::grasp::Grasp;
use landscape::space::Pose;
use landscape::store::exchange::{QposRow, dexgraspnet_npy, qpos_npy};
use landscape::store::{
    AtomicFolder, EdgeRow, GraspFile, GraspRow, Journal, LandscapeFiles, MinimumRow, Overrides,
    PathPoint, StationaryRow, write_attempts,
};
use landscape::topography::{Attempt, MinimumId, Start};
use parquet::file::reader::{FileReader, SerializedFileReader};
use tempfile::TempDir;
use zip::CompressionMethod;

pub(crate) const URDF: &str = r#"<?xml version="1.0"?><robot name="r"><material name="m"><color rgba="1 0 0 1"/></material>
<link name="a"><inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
<visual><geometry><sphere radius="0.02"/></geometry></visual><collision><origin xyz="0 0 0.1" rpy="0 1 0"/><geometry><box size="0.1 0.2 0.3"/></geometry></collision></link>
<link name="b"><collision><geometry><cylinder radius="0.01" length="0.05"/></geometry></collision></link>
<link name="c"><collision><geometry><capsule radius="0.01" length="0.05"/></geometry></collision></link>
<joint name="j" type="revolute"><parent link="a"/><child link="b"/><origin xyz="0 0.1 0" rpy="0 0 1"/><axis xyz="1 0 0"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
<joint name="k" type="prismatic"><parent link="b"/><child link="c"/><axis xyz="0 1 0"/><limit lower="0" upper="0.1" effort="1" velocity="1"/><mimic joint="j" multiplier="2" offset="0.1"/></joint></robot>"#;

pub(crate) const MJCF: &str = r#"<mujoco model="m"><compiler angle="degree" eulerseq="xyz" autolimits="true"/>
<default><joint axis="0 1 0" range="-40 80"/><geom type="capsule" size="0.01 0.02"/><default class="k"><geom size="0.015 0.02"/></default></default>
<asset><mesh name="tet" vertex="0 0 0 0.1 0 0 0 0.1 0 0 0 0.1" face="0 2 1 0 1 3 0 3 2 1 2 3" scale="1 1 1"/></asset>
<worldbody><frame pos="0.1 0 0" euler="10 20 30"><body name="p" axisangle="1 1 0 40" childclass="k"><freejoint/><geom type="mesh" mesh="tet"/>
<body name="a" pos="0.03 0 0" xyaxes="0 1 0 -1 0 0.2"><joint name="a1" pos="0 0.01 0.02"/><joint name="a2" axis="1 0 0" ref="15"/><geom pos="0 0 0.03"/>
<body name="c" quat="1 0 0 1"><joint name="c1" type="slide" range="0 0.1"/><geom type="ellipsoid" size="0.01 0.02 0.03"/></body></body>
<body name="b" zaxis="0 1 1"><joint name="b1"/><geom fromto="0 0 0 0.01 0.02 0.05" size="0.008"/><geom type="box" size="0.01 0.01 0.01"/></body></body></frame></worldbody>
<equality><joint joint1="a2" joint2="a1" polycoef="0.1 0.5 0 0 0"/></equality><tendon><fixed name="t"><joint joint="a1" coef="1"/><joint joint="b1" coef="-1"/></fixed></tendon>
<contact><exclude body1="a" body2="b"/></contact></mujoco>"#;

pub(crate) const SIDE: &str = r#"{"name": "s", "without": ["c"], "surface_points": 30, "no_contact": ["a"], "apart": [["a", "b"]],
"palm": {"centre_m": [0, 0, 0], "volar": [0, 0, 1], "distal": [0, 1, 0], "faced_m": 0.01},
"digits": [{"name": "thumb", "segments": {"distal": ["b"]}}], "axes": {"pad": [0, 0, 1], "radial": [1, 0, 0], "distal": [0, 1, 0]},
"palm_regions": [{"region": "x", "normal": [0, 0, 1], "at_least": 0.5, "min_m": [-1, -1, -1], "max_m": [1, 1, 1]}],
"capsules": {"a": [{"a_m": [0, 0, 0], "b_m": [0, 0, 0.1], "radius_m": 0.01}]}, "rest_deg": {"j": 10}, "deviation_deg": {"j": 5},
"synergies": [{"name": "y", "variance": 1, "weights": {"j": 1}}], "independent_share": 0.5, "metric": {"radius_of_gyration_m": 0.05, "levers_m": {"j": 0.01}}}"#;

pub(crate) const ISAAC: &str = r#"format: isaac_grasp
format_version: "1.0"
object_frame_link: /World/mug
object_scale: 0.5
gripper_frame_link: palm
grasps:
  'grasp_0': # first
    confidence: 1.0
    position: [0.0, 0.0, -0.07]
    orientation: {w: 1.0, xyz: [0.0, 0.0, 0.0]}
    cspace_position: {jaw: 0.03}
  "grasp_1":
    position:
      - 0
      - 1e-2
      - -.07
    orientation:
      w: 0
      xyz: [0, 0, 1]
    pregrasp_cspace_position:
      jaw: 0.04
"#;

pub(crate) const TRANSFORMS: &str = r#"{"object": {"file": "mug.obj", "scale": 0.5}, "grasps": {"transforms":
[[[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, -0.12], [0, 0, 0, 1]], [[0, -1, 0, 0.1], [1, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]],
"object_in_gripper": [true, 0]}}"#;

pub(crate) const OBJ: &str = "o one\nv 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\nvn 0 0 1\nvt 0 0\nf 1 3 2\nf 1/1/1 2/1/1 4/1/1\ng rest\nusemtl none\nf 1 4 3\nf -1 -3 -2\n";

pub(crate) const STL: &str = "solid t\nfacet normal 0 0 -1\nouter loop\nvertex 0 0 0\nvertex 0 0.1 0\nvertex 0.1 0 0\nendloop\nendfacet
facet normal 0 0 -1\nouter loop\nvertex 0 0 0\nvertex 0.1 0 0\nvertex 0 0 0.1\nendloop\nendfacet
facet normal 0 0 -1\nouter loop\nvertex 0 0 0\nvertex 0 0 0.1\nvertex 0 0.1 0\nendloop\nendfacet
facet normal 1 1 1\nouter loop\nvertex 0.1 0 0\nvertex 0 0.1 0\nvertex 0 0 0.1\nendloop\nendfacet\nendsolid t\n";

pub(crate) const PLY: &str = "ply\nformat ascii 1.0\ncomment a\nelement vertex 4\nproperty float x\nproperty float y\nproperty double z\nproperty uchar red\n\
element face 4\nproperty list uchar int vertex_indices\nend_header\n0 0 0 1\n0.1 0 0 1\n0 0.1 0 1\n0 0 0.1 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";

/// One mesh of two kinds of faces that is shown twice, once mirrored.
pub(crate) const DAE: &str = r##"<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1"><asset><unit meter="0.1"/></asset>
<library_geometries><geometry id="g"><mesh><source id="s"><float_array id="a" count="12">0 0 0 1 0 0 0 1 0 0 0 1</float_array>
<technique_common><accessor source="#a" count="4" stride="3"/></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#s"/></vertices>
<triangles count="2"><input semantic="VERTEX" source="#v" offset="0"/><input semantic="NORMAL" source="#s" offset="1"/><p>0 0 2 0 1 0 0 0 1 0 3 0</p></triangles>
<polylist count="2"><input semantic="VERTEX" source="#v" offset="0"/><vcount>3 3</vcount><p>0 3 2 1 2 3</p></polylist></mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="w"><node><translate>0 0 0.1</translate><rotate>0 0 1 30</rotate><instance_geometry url="#g"/>
<node><scale>-1 1 1</scale><instance_geometry url="#g"/></node></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#w"/></scene></COLLADA>"##;

/// One mesh that is placed twice and refers to a file of its folder.
pub(crate) const GLTF: &str = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"children":[1,2],"scale":[0.5,0.5,0.5]},
{"mesh":0,"translation":[1,0,0],"rotation":[0,0,0.7071,0.7071]},{"mesh":0,"matrix":[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1]}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1,"mode":4}]}],
"accessors":[{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3"},{"bufferView":1,"componentType":5125,"count":12,"type":"SCALAR"}],
"bufferViews":[{"buffer":0,"byteLength":48},{"buffer":0,"byteOffset":48,"byteLength":48,"byteStride":4}],"buffers":[{"byteLength":96,"uri":"m.bin"}]}"#;

pub(crate) const SHAPES: &str = "name = \"rod\"\nmass_kg = 0.4\nsymmetry = { axis = { point = [0, 0, 0], direction = [0, 0, 1] } }\n\
[[parts]]\ncylinder = { centre = [0, 0, 0], axis = [0, 0, 1], radius_m = 0.012, half_height_m = 0.06 }\n";

pub(crate) const TABLE: &str = "id,scale,translation_m_x,translation_m_y,translation_m_z,rotation_w,rotation_x,rotation_y,rotation_z,label,jaw,contacts\n\
7,1,0.1,0.02,0.0333333333333333,0.5,0.5,-0.5,0.5,\"pinch, wide\",0.025,1 2 3\n9,1,-0.08,0.011,0.05,0.6,0.0,0.8,0.0,,0.03,[4;5;6]\n";

pub(crate) const ROWS: &str = r#"[{"id":1,"object":"ball","scale":1,"translation_m":[0.1,0.2,0.3],"rotation_wxyz":[1,0,0,0],"jaw":0.01,"contacts":[1,2],"label":null},
{"id":2,"object":"ball","scale":1,"translation_m":[0.1,0.2,0.3],"rotation_wxyz":[0.5,0.5,0.5,0.5],"jaw":0.02,"contacts":[1,2],"label":"b"}]"#;

/// The mapping for [`TABLE`].
pub(crate) const MAPPING: &str = "translation = [\"translation_m_x\", \"translation_m_y\", \"translation_m_z\"]\ntranslation_unit = \"cm\"\n\
rotation = [\"rotation_w\", \"rotation_x\", \"rotation_y\", \"rotation_z\"]\nrotation_form = \"xyzw\"\nrotation_unit = \"deg\"\nframe = \"hand_from_object\"\n\
joints = { jaw = \"jaw\" }\njoint_unit = \"deg\"\nscale = \"scale\"\nid = \"id\"\nlabel = \"label\"\ncontacts = \"contacts\"\n";

pub(crate) const PROTOCOL: &str = "protocol = \"dexgraspbench\"\nmass_kg = 0.1\nfriction = 0.6\n[closing]\nrule = \"squeeze\"\nforce_n = 4.0\n\
stiffness_n_m = 5.0\n[loads]\ndirections = [[1, 0, 0], [0.0, -1.0, 0.5]]\nseconds = 2.0\n[criterion]\ndisplacement_m = 0.05\n";

pub(crate) const POINTS: &str = "# two points\n0.5 -1.0\n1e-3, 2 # the second\n";

pub(crate) const EXCHANGE: &str = "-1.5 1.0 1 1.0 1.0 1.0\n-1.0 1.0 1 1.0 1.0 1.0\n0.5 1.0 1 1 2 1.0 1.0 1.0\n0.7 1.0 1 2 1 1.0 1.0 1.0\n";

const CORNERS: [[f32; 3]; 4] = [[0.0; 3], [0.1, 0.0, 0.0], [0.0, 0.1, 0.0], [0.0, 0.0, 0.1]];
const FACES: [[u32; 3]; 4] = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];

pub(crate) fn binary_stl() -> Vec<u8> {
    let mut bytes = vec![0u8; 80];
    bytes.extend(4u32.to_le_bytes());
    for face in FACES {
        bytes.extend([0u8; 12]);
        let points = face.iter().flat_map(|&v| CORNERS[v as usize]);
        bytes.extend(points.flat_map(f32::to_le_bytes));
        bytes.extend([0u8; 2]);
    }
    bytes
}

pub(crate) fn binary_ply() -> Vec<u8> {
    let mut bytes = b"ply\nformat binary_little_endian 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
        element face 4\nproperty list uchar uint vertex_indices\nend_header\n"
        .to_vec();
    bytes.extend(CORNERS.iter().flatten().flat_map(|x| x.to_le_bytes()));
    for face in FACES {
        bytes.push(3);
        bytes.extend(face.iter().flat_map(|corner| corner.to_le_bytes()));
    }
    bytes
}

/// [`GLTF`] with an embedded buffer, as text and as binary file.
pub(crate) fn gltf() -> (Vec<u8>, Vec<u8>) {
    let corners = CORNERS.iter().flatten().flat_map(|x| x.to_le_bytes());
    let faces = FACES.iter().flatten().flat_map(|index| index.to_le_bytes());
    let data: Vec<u8> = corners.chain(faces).collect();
    let uri = format!("data:x;base64,{}", STANDARD.encode(&data));
    let within = GLTF.replace("m.bin", &uri).into_bytes();
    let mut text = GLTF.replace(r#","uri":"m.bin""#, "").into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut binary = b"glTF".to_vec();
    let mut word = |number: usize, more: &[u8]| {
        binary.extend(u32::try_from(number).unwrap().to_le_bytes());
        binary.extend(more);
    };
    word(2, &[]);
    word(28 + text.len() + data.len(), &[]);
    word(text.len(), &[&b"JSON"[..], &text].concat());
    word(data.len(), &[&b"BIN\0"[..], &data].concat());
    (within, binary)
}

/// Files of graspqp and `MultiDex` for one joint.
pub(crate) fn tensors() -> Vec<Vec<u8>> {
    let q = [0.0, 0.0, 0.1, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.02];
    let root = [0.0, 0.0, 0.1, 0.0, 0.0, 0.0, 1.0];
    let parameters: [(&str, &[u8], &[f32]); 2] =
        [("jaw", &[1], &[0.02]), ("root_pose", &[1, 7], &root)];
    let contents = [
        Tensors::Parameters(&parameters),
        Tensors::Metadata(&[(&q, "apple", "allegro")]),
    ];
    contents.iter().map(torch_of).collect()
}

/// DexGraspBench's dictionaries in numpy's form, those of DexGraspNet, and a table of numbers, all for one joint.
pub(crate) fn pickles() -> Vec<Vec<u8>> {
    let grasp = |id| GraspRow {
        id,
        scale: 1.0,
        grasp: Grasp::new(
            Pose::new([0.0; 3], [0.5, 0.5, -0.5, 0.5], &[0.02]),
            Vec::new(),
        ),
        ..GraspRow::default()
    };
    let grasps = [grasp(0), grasp(1)];
    let rows = [0, 1].map(|id| QposRow {
        id,
        qpos: vec![0.1, 0.2, 0.3, 0.5, 0.5, 0.5, 0.5, 0.01],
    });
    let mut files = pickled::bench().to_vec();
    files.push(pickled::bodex());
    files.push(pickled::nested());
    files.push(dexgraspnet_npy(&grasps.each_ref(), &joints()));
    files.push(qpos_npy(&rows));
    files
}

pub(crate) fn joints() -> [String; 1] {
    ["jaw".to_owned()]
}

/// A checkpoint of torch: an archive with a pickle. It is refused, but a file with another ending may contain it.
pub(crate) fn checkpoint() -> Vec<u8> {
    let mut archive = zip::ZipWriter::new(Cursor::new(Vec::new()));
    let options = zip::write::SimpleFileOptions::default();
    archive.start_file("model/data.pkl", options).unwrap();
    archive
        .write_all(b"\x80\x02}q\x00X\x04\x00\x00\x00lin0ctorch._utils\n_rebuild_tensor_v2\n.")
        .unwrap();
    archive.finish().unwrap().into_inner()
}

pub(crate) fn msh() -> Vec<u8> {
    let counts = [4i32, 0, 0, 4].iter().flat_map(|count| count.to_le_bytes());
    let corners = CORNERS.iter().flatten().flat_map(|x| x.to_le_bytes());
    let faces = FACES.iter().flatten().flat_map(|index| index.to_le_bytes());
    counts.chain(corners).chain(faces).collect()
}

/// An archive of arrays with MANO's names, too small to be valid.
pub(crate) fn npz(method: CompressionMethod) -> Vec<u8> {
    let mut archive = zip::ZipWriter::new(Cursor::new(Vec::new()));
    let options = zip::write::SimpleFileOptions::default().compression_method(method);
    for (name, shape, numbers) in [
        ("v_template", "(2, 3)", 6),
        ("f", "(1, 3)", 3),
        ("shapedirs", "(2, 3, 1)", 6),
    ] {
        let header = format!("{{'descr': '<f8', 'fortran_order': True, 'shape': {shape}, }}\n");
        archive.start_file(format!("{name}.npy"), options).unwrap();
        archive.write_all(b"\x93NUMPY\x01\x00").unwrap();
        archive
            .write_all(&u16::try_from(header.len()).unwrap().to_le_bytes())
            .unwrap();
        archive.write_all(header.as_bytes()).unwrap();
        archive.write_all(&vec![0; 8 * numbers]).unwrap();
    }
    archive.finish().unwrap().into_inner()
}

/// A small file of grasps.
pub(crate) fn parquet() -> Vec<u8> {
    let whole = Path::new(crate::PROJECT).join("data/grasps.parquet");
    let (mut file, _) = GraspFile::read(&whole, Overrides::default()).unwrap();
    file.grasps.truncate(2);
    for object in &mut file.metadata.objects {
        object.mesh_obj = Some("v 0 0 0\n".repeat(9));
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("small.parquet");
    file.write(&path).unwrap();
    without_checksum(fs::read(path).unwrap())
}

/// A table whose checksum has an unused name. With the checksum, no reader would interpret mutated bytes.
pub(crate) fn without_checksum(mut table: Vec<u8>) -> Vec<u8> {
    let key = b"landscape_checksum";
    let at = table.windows(key.len()).rposition(|window| window == key);
    table[at.unwrap()] = b'L';
    table
}

/// The JSON metadata in a Parquet file of grasps.
pub(crate) fn described() -> Vec<u8> {
    let file = SerializedFileReader::new(Bytes::from(parquet())).unwrap();
    let pairs = file.metadata().file_metadata().key_value_metadata();
    let own = pairs.unwrap().iter().find(|pair| pair.key == OWN_KEY);
    own.and_then(|pair| pair.value.clone())
        .unwrap()
        .into_bytes()
}

/// Metadata key of the program's own tables.
pub(crate) const OWN_KEY: &str = "landscape";

/// A file of a small landscape.
pub(crate) fn landscape(name: &str) -> Vec<u8> {
    fs::read(landscape_folder().join(name)).unwrap()
}

/// A landscape with two minima, written once per process.
pub(crate) fn landscape_folder() -> &'static Path {
    static FOLDER: OnceLock<(TempDir, PathBuf)> = OnceLock::new();
    let minimum = |id: u64| MinimumRow {
        id,
        energy: 0.1 * id as f64,
        coordinates: vec![0.1, id as f64],
        members: vec![id, u64::MAX],
        family: id,
        labels: [("medium wrap".to_owned(), 2)].into(),
    };
    let (_, path) = FOLDER.get_or_init(|| {
        let place = tempfile::tempdir().unwrap();
        let folder = AtomicFolder::open(&place.path().join("a.landscape"), true).unwrap();
        let files = LandscapeFiles {
            minima: vec![minimum(0), minimum(1)],
            edges: vec![EdgeRow {
                b: 1,
                height: Some(0.5),
                evidence: "path".to_owned(),
                chains_forward: vec![0.9, 0.8],
                ..EdgeRow::default()
            }],
            paths: vec![PathPoint {
                b: 1,
                coordinates: vec![0.1, 0.5],
                energy: 0.5,
                ..PathPoint::default()
            }],
            ..LandscapeFiles::default()
        };
        files.write(&folder).unwrap();
        let saddle = StationaryRow {
            index: 1,
            ends: [0, 1],
            coordinates: vec![0.1, 0.5],
            curvatures: vec![-1.0, 2.0],
            verdict: "saddle".to_owned(),
            ..StationaryRow::default()
        };
        StationaryRow::write(&[saddle], &folder).unwrap();
        let attempt = |start, barrier: Option<f64>| Attempt {
            from: MinimumId(0),
            to: MinimumId(1),
            start,
            law: barrier.map(|_| [0.1, 2.0]),
            free_temperature: barrier,
            barrier,
            height: Some(0.5),
        };
        let chain = Start::Chain {
            backward: true,
            replica: 0,
        };
        let attempts = [attempt(chain, Some(0.9)), attempt(Start::Straight, None)];
        write_attempts(&attempts, &folder).unwrap();
        let path = folder.finish().unwrap();
        for entry in fs::read_dir(&path).unwrap() {
            let file = entry.unwrap().path();
            if file.extension().unwrap() == "parquet" {
                let bytes = without_checksum(fs::read(&file).unwrap());
                fs::write(file, bytes).unwrap();
            }
        }
        (place, path)
    });
    path
}

/// The hash with which the journal was begun.
pub(crate) const INPUT_HASH: &str = "0123456789abcdef";

pub(crate) fn journal() -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("journal");
    let journal = Journal::open(&path, INPUT_HASH, true).unwrap();
    for (key, payload) in [("chain 0", &b"[1.5]"[..]), ("chain 1", b""), ("a", b"{}")] {
        journal.put(key, payload).unwrap();
    }
    drop(journal);
    fs::read(path).unwrap()
}

/// A grasp that a person named, with two features.
pub(crate) fn example(i: usize) -> Example {
    let class = i % 2;
    let features = [("fact thumb", class as f64), ("width", 0.1 * i as f64)];
    Example {
        group: format!("object {}", i / 10),
        features: features
            .map(|(name, value)| (name.to_owned(), value))
            .into(),
        rule: vec![0.03; UNLISTED_CLASS + 1],
        class,
    }
}

/// A labeller that was taught with thirty grasps.
pub(crate) fn labeller() -> Vec<u8> {
    let examples: Vec<Example> = (0..30).map(example).collect();
    let taught = Taught::of(&examples, Vec::new(), "0").unwrap();
    taught.text().into_bytes()
}

pub(crate) fn text(text: &str) -> Vec<u8> {
    text.as_bytes().to_vec()
}

pub(crate) fn bytes(name: &str) -> Vec<u8> {
    fs::read(Path::new(crate::PROJECT).join(name)).unwrap()
}
