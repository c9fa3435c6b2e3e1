//! numpy files that contain pickles.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

/// `numpy.save` of the dictionary of DexGraspBench for a hand with one joint and two grasps: by numpy 2, and with protocols
/// 5 and 3.
const BENCH: [&str; 3] = [
    "\
    k05VTVBZAQB2AHsnZGVzY3InOiAnfE8nLCAnZm9ydHJhbl9vcmRlcic6IEZhbHNlLCAnc2hhcGUnOiAoKSwgfSAgICAgICAgICAgICAgICAgIC\
    AgICAgICAgICAgICAgICAgICAgICAgICAgICAgICAgICAgICAgICAgICAgIAqABJV+AgAAAAAAAIwWbnVtcHkuX2NvcmUubXVsdGlhcnJheZSM\
    DF9yZWNvbnN0cnVjdJSTlIwFbnVtcHmUjAduZGFycmF5lJOUSwCFlEMBYpSHlFKUKEsBKWgDjAVkdHlwZZSTlIwCTziUiYiHlFKUKEsDjAF8lE\
    5OTkr/////Sv////9LP3SUYoldlH2UKIwIb2JqX3Bvc2WUaAJoBUsAhZRoB4eUUpQoSwFLB4WUaAuMAmY4lImIh5RSlChLA4wBPJROTk5K////\
    /0r/////SwB0lGKJQziamZmZmZm5P5qZmZmZmck/MzMzMzMz0z/NO39mnqDmPwAAAAAAAAAAAAAAAAAAAADNO39mnqDmP5R0lGKMCW9ial9zY2\
    FsZZRoAIwGc2NhbGFylJOUaAuMAmY0lImIh5RSlChLA2gbTk5OSv////9K/////0sAdJRiQwQAAIA/lIaUUpSMCG9ial9wYXRolIwVYXNzZXRz\
    L2JhbGwvaW5mby5qc29ulIwKZ3Jhc3BfcXBvc5RoAmgFSwCFlGgHh5RSlChLAUsCSwiGlGgkiUNAzcxMPQrXIzwAAAAAAAAAPwAAAD8AAAA/AA\
    AAPwrXozwAAAAAj8J1vc3MzD0AAAAAAAAAAAAAgD8AAAAAj8J1PJR0lGKMDXByZWdyYXNwX3Fwb3OUaAJoBUsAhZRoB4eUUpQoSwFLAksIhpRo\
    JIlDQJDCdT0K16M8CtcjPFyPAj9cjwI/XI8CP1yPAj+PwvU8CtcjPMzMTL2uR+E9CtcjPArXIzyuR4E/CtcjPMzMzDyUdJRijARub3RllE6MAm\
    9rlIiMAW6USweMAXOUXZQoSwFHQAQAAAAAAABldWF0lGIu\
",
    "\
    k05VTVBZAQB2AHsnZGVzY3InOiAnfE8nLCAnZm9ydHJhbl9vcmRlcic6IEZhbHNlLCAnc2hhcGUnOiAoKSwgfSAgICAgICAgICAgICAgICAgIC\
    AgICAgICAgICAgICAgICAgICAgICAgICAgICAgICAgICAgICAgICAgICAgIAqABZWVAgAAAAAAAIwWbnVtcHkuX2NvcmUubXVsdGlhcnJheZSM\
    DF9yZWNvbnN0cnVjdJSTlIwFbnVtcHmUjAduZGFycmF5lJOUSwCFlEMBYpSHlFKUKEsBKWgDjAVkdHlwZZSTlIwCTziUiYiHlFKUKEsDjAF8lE\
    5OTkr/////Sv////9LP3SUYoldlH2UKIwIb2JqX3Bvc2WUjBNudW1weS5fY29yZS5udW1lcmljlIwLX2Zyb21idWZmZXKUk5QoljgAAAAAAAAA\
    mpmZmZmZuT+amZmZmZnJPzMzMzMzM9M/zTt/Zp6g5j8AAAAAAAAAAAAAAAAAAAAAzTt/Zp6g5j+UaAuMAmY4lImIh5RSlChLA4wBPJROTk5K//\
    ///0r/////SwB0lGJLB4WUjAFDlHSUUpSMCW9ial9zY2FsZZRoAIwGc2NhbGFylJOUaAuMAmY0lImIh5RSlChLA2gbTk5OSv////9K/////0sA\
    dJRiQwQAAIA/lIaUUpSMCG9ial9wYXRolIwVYXNzZXRzL2JhbGwvaW5mby5qc29ulIwKZ3Jhc3BfcXBvc5RoFiiWQAAAAAAAAADNzEw9CtcjPA\
    AAAAAAAAA/AAAAPwAAAD8AAAA/CtejPAAAAACPwnW9zczMPQAAAAAAAAAAAACAPwAAAACPwnU8lGgmSwJLCIaUaB50lFKUjA1wcmVncmFzcF9x\
    cG9zlGgWKJZAAAAAAAAAAJDCdT0K16M8CtcjPFyPAj9cjwI/XI8CP1yPAj+PwvU8CtcjPMzMTL2uR+E9CtcjPArXIzyuR4E/CtcjPMzMzDyUaC\
    ZLAksIhpRoHnSUUpSMBG5vdGWUTowCb2uUiIwBbpRLB4wBc5RdlChLAUdABAAAAAAAAGV1YXSUYi4=\
",
    "\
    k05VTVBZAQB2AHsnZGVzY3InOiAnfE8nLCAnZm9ydHJhbl9vcmRlcic6IEZhbHNlLCAnc2hhcGUnOiAoKSwgfSAgICAgICAgICAgICAgICAgIC\
    AgICAgICAgICAgICAgICAgICAgICAgICAgICAgICAgICAgICAgICAgICAgIAqAA2NudW1weS5fY29yZS5tdWx0aWFycmF5Cl9yZWNvbnN0cnVj\
    dApxAGNudW1weQpuZGFycmF5CnEBSwCFcQJDAWJxA4dxBFJxBShLASljbnVtcHkKZHR5cGUKcQZYAgAAAE84cQeJiIdxCFJxCShLA1gBAAAAfH\
    EKTk5OSv////9K/////0s/dHELYoldcQx9cQ0oWAgAAABvYmpfcG9zZXEOaABoAUsAhXEPaAOHcRBScREoSwFLB4VxEmgGWAIAAABmOHETiYiH\
    cRRScRUoSwNYAQAAADxxFk5OTkr/////Sv////9LAHRxF2KJQziamZmZmZm5P5qZmZmZmck/MzMzMzMz0z/NO39mnqDmPwAAAAAAAAAAAAAAAA\
    AAAADNO39mnqDmP3EYdHEZYlgJAAAAb2JqX3NjYWxlcRpjbnVtcHkuX2NvcmUubXVsdGlhcnJheQpzY2FsYXIKcRtoBlgCAAAAZjRxHImIh3Ed\
    UnEeKEsDaBZOTk5K/////0r/////SwB0cR9iQwQAAIA/cSCGcSFScSJYCAAAAG9ial9wYXRocSNYFQAAAGFzc2V0cy9iYWxsL2luZm8uanNvbn\
    EkWAoAAABncmFzcF9xcG9zcSVoAGgBSwCFcSZoA4dxJ1JxKChLAUsCSwiGcSloHolDQM3MTD0K1yM8AAAAAAAAAD8AAAA/AAAAPwAAAD8K16M8\
    AAAAAI/Cdb3NzMw9AAAAAAAAAAAAAIA/AAAAAI/CdTxxKnRxK2JYDQAAAHByZWdyYXNwX3Fwb3NxLGgAaAFLAIVxLWgDh3EuUnEvKEsBSwJLCI\
    ZxMGgeiUNAkMJ1PQrXozwK1yM8XI8CP1yPAj9cjwI/XI8CP4/C9TwK1yM8zMxMva5H4T0K1yM8CtcjPK5HgT8K1yM8zMzMPHExdHEyYlgEAAAA\
    bm90ZXEzTlgCAAAAb2txNIhYAQAAAG5xNUsHWAEAAABzcTZdcTcoSwFHQAQAAAAAAABldWF0cThiLg==\
",
];

/// The three files.
pub(crate) fn bench() -> [Vec<u8>; 3] {
    BENCH.map(|text| STANDARD.decode(text).unwrap())
}

/// A value of a pickled dictionary.
pub(crate) enum Value<'a> {
    Text(&'a str),
    Texts(&'a [&'a str]),
    /// An array of numbers with its shape.
    Array(&'a [usize], &'a [f64]),
    Dictionary(&'a [(&'a str, Self)]),
}

/// Position, quaternion and joint of a grasp.
pub(crate) const QPOS: [f64; 8] = [0.01, 0.02, -0.1, 0.5, 0.5, -0.5, 0.5, 0.25];
const ORIGIN: [f64; 7] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0];

/// A file of `BODex`: of the three poses of its grasp, the second is [`QPOS`].
pub(crate) fn bodex() -> Vec<u8> {
    let other = [0.0, 0.0, 0.3, 1.0, 0.0, 0.0, 0.0, 0.0];
    let poses: Vec<f64> = [other, QPOS, other].concat();
    let ball = [
        ("scale", Value::Array(&[3], &[0.5; 3])),
        ("pose", Value::Array(&[7], &ORIGIN)),
    ];
    let meshes = [
        ("scene_ball", Value::Dictionary(&ball)),
        ("scene_table", Value::Dictionary(&[])),
    ];
    npy_of(&Value::Dictionary(&[
        ("robot_pose", Value::Array(&[1, 1, 3, 8], &poses)),
        ("joint_names", Value::Texts(&["jaw"])),
        ("manip_name", Value::Texts(&["scene_ball"])),
        (
            "world_cfg",
            Value::Dictionary(&[("mesh", Value::Dictionary(&meshes))]),
        ),
    ]))
}

/// A file of Dexonomy with its scene, and with a factor on the scale of each grasp.
pub(crate) fn nested() -> Vec<u8> {
    let ball = [
        ("type", Value::Text("rigid_object")),
        ("scale", Value::Array(&[3], &[0.5; 3])),
        ("pose", Value::Array(&[7], &ORIGIN)),
    ];
    let objects = [("ball", Value::Dictionary(&ball))];
    let task = [("obj_name", Value::Text("ball"))];
    let scene = [
        ("scene", Value::Dictionary(&objects)),
        ("task", Value::Dictionary(&task)),
    ];
    npy_of(&Value::Dictionary(&[
        ("grasp_qpos", Value::Array(&[1, 8], &QPOS)),
        ("scene_cfg", Value::Dictionary(&scene)),
        ("scene_scale", Value::Array(&[1], &[2.0])),
    ]))
}

/// A file of numpy that holds one object, as `numpy.save` of a dictionary.
pub(crate) fn npy_of(value: &Value<'_>) -> Vec<u8> {
    let mut header = b"{'descr': '|O', 'fortran_order': False, 'shape': (), }".to_vec();
    header.resize(117, b' ');
    header.push(b'\n');
    let mut bytes = b"\x93NUMPY\x01\x00\x76\x00".to_vec();
    bytes.extend(header);
    bytes.extend(b"\x80\x03");
    write(&mut bytes, value);
    bytes.push(b'.');
    bytes
}

fn write(bytes: &mut Vec<u8>, value: &Value<'_>) {
    match value {
        Value::Text(text) => {
            bytes.push(b'X');
            bytes.extend(u32::try_from(text.len()).unwrap().to_le_bytes());
            bytes.extend(text.as_bytes());
        }
        Value::Texts(texts) => {
            bytes.extend(b"](");
            for text in *texts {
                write(bytes, &Value::Text(text));
            }
            bytes.push(b'e');
        }
        Value::Array(shape, values) => {
            bytes.extend(b"cnumpy.core.numeric\n_frombuffer\n(B");
            bytes.extend(u32::try_from(8 * values.len()).unwrap().to_le_bytes());
            bytes.extend(values.iter().flat_map(|value| value.to_le_bytes()));
            bytes.extend(b"cnumpy\ndtype\nX\x03\x00\x00\x00<f8\x85R(");
            for side in *shape {
                bytes.push(b'J');
                bytes.extend(i32::try_from(*side).unwrap().to_le_bytes());
            }
            bytes.extend(b"tX\x01\x00\x00\x00CtR");
        }
        Value::Dictionary(entries) => {
            bytes.extend(b"}(");
            for (key, value) in *entries {
                write(bytes, &Value::Text(key));
                write(bytes, value);
            }
            bytes.push(b'u');
        }
    }
}

/// Content of a file of torch.
pub(crate) enum Tensors<'a> {
    /// Of graspqp: name, shape and numbers of each tensor.
    Parameters(&'a [(&'a str, &'a [u8], &'a [f32])]),
    /// Of `MultiDex` and DRO-Grasp: numbers, object and robot of each grasp.
    Metadata(&'a [(&'a [f32], &'a str, &'a str)]),
}

/// A file as `torch.save` writes it.
pub(crate) fn torch_of(content: &Tensors<'_>) -> Vec<u8> {
    let mut pickle = b"\x80\x02}(".to_vec();
    let mut storages = Vec::new();
    match content {
        Tensors::Parameters(tensors) => {
            write(&mut pickle, &Value::Text("parameters"));
            pickle.extend(b"}(");
            for (name, shape, numbers) in *tensors {
                write(&mut pickle, &Value::Text(name));
                tensor(&mut pickle, shape, numbers, &mut storages);
            }
            pickle.push(b'u');
        }
        Tensors::Metadata(grasps) => {
            write(&mut pickle, &Value::Text("metadata"));
            pickle.extend(b"](");
            for (numbers, object, robot) in *grasps {
                let length = u8::try_from(numbers.len()).unwrap();
                tensor(&mut pickle, &[length], numbers, &mut storages);
                write(&mut pickle, &Value::Text(object));
                write(&mut pickle, &Value::Text(robot));
                pickle.push(0x87);
            }
            pickle.push(b'e');
        }
    }
    pickle.extend(b"u.");
    let mut archive = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
    let options =
        zip::write::SimpleFileOptions::default().compression_method(zip::CompressionMethod::Stored);
    let data = (storages.iter().enumerate()).map(|(key, bytes)| (format!("g/data/{key}"), bytes));
    for (name, bytes) in [("g/data.pkl".to_owned(), &pickle)].into_iter().chain(data) {
        archive.start_file(name, options).unwrap();
        std::io::Write::write_all(&mut archive, bytes).unwrap();
    }
    archive.finish().unwrap().into_inner()
}

/// A tensor in row-major order with a storage of its own.
fn tensor(pickle: &mut Vec<u8>, shape: &[u8], numbers: &[f32], storages: &mut Vec<Vec<u8>>) {
    pickle.extend(b"ctorch._utils\n_rebuild_tensor_v2\n((");
    write(pickle, &Value::Text("storage"));
    pickle.extend(b"ctorch\nFloatStorage\n");
    write(pickle, &Value::Text(&storages.len().to_string()));
    write(pickle, &Value::Text("cpu"));
    pickle.extend([b'K', u8::try_from(numbers.len()).unwrap()]);
    pickle.extend(b"tQK\x00(");
    for side in shape {
        pickle.extend([b'K', *side]);
    }
    pickle.extend(b"t(");
    for place in 0..shape.len() {
        let stride: u8 = shape[place + 1..].iter().product();
        pickle.extend([b'K', stride]);
    }
    pickle.extend(b"t\x89ccollections\nOrderedDict\n)RtR");
    storages.push(
        numbers
            .iter()
            .flat_map(|number| number.to_le_bytes())
            .collect(),
    );
}
