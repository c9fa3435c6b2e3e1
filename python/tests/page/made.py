"""Landscapes and files of grasps from the committed grasps, without a search."""

import json
import re
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

COMMITTED = Path(__file__).parents[3] / "data/grasps.parquet"
DESCRIPTION = pq.read_metadata(COMMITTED).metadata[b"landscape"]
#: Points of a path, as many as relaxed paths have.
IMAGES = 24


def grasps(count=None):
    """The committed grasps as a table."""
    return pq.read_table(COMMITTED).slice(0, count).replace_schema_metadata({b"landscape": DESCRIPTION})


def with_column(table, name, values):
    """The table with other values in a column."""
    place = table.schema.get_field_index(name)
    return table.set_column(place, table.schema.field(name), pa.array(values, table.schema.field(name).type))


def described(table, metadata):
    """The table with this description."""
    return table.replace_schema_metadata({b"landscape": json.dumps(metadata).encode()})


def metadata(exact=True):
    """The description of the committed grasps. For `pretty`, numbers with a point stay texts, marked, so that they keep their form."""
    return json.loads(DESCRIPTION, parse_float=marked if exact else float)


def marked(text):
    return "\x01" + text


def pretty(document):
    """The document in the form in which the program writes it."""
    text = json.dumps(document, indent=2, sort_keys=True, ensure_ascii=False)
    return (re.sub(r'"\\u0001([^"]*)"', r"\1", text) + "\n").encode()


def checksum(content):
    """The checksum of landscapes, 128 bits of FNV-1a."""
    total = 0x6C62272E07BB014262B821756295C58D
    for byte in len(content).to_bytes(8, "little") + content:
        total = (total ^ byte) * 0x13B + ((total ^ byte) << 88) & (1 << 128) - 1
    return f"{total:032x}"


def finish(folder, manifest):
    """Writes the manifest of a landscape with the checksums of its tables."""
    document = {**manifest, "format": "landscape", "schema_version": 1}
    document.pop("checksums", None)
    sums = {"landscape.json": checksum(pretty(document))}
    sums.update({path.name: checksum(path.read_bytes()) for path in sorted(folder.glob("*.parquet"))})
    (folder / "landscape.json").write_bytes(pretty({**document, "checksums": sums}))


def changed(folder, change):
    """Changes the manifest of a landscape and its tables, which are lists of rows."""
    manifest = json.loads((folder / "landscape.json").read_text(), parse_float=marked)
    tables = {name: pq.read_table(folder / f"{name}.parquet") for name in ("minima", "edges", "paths")}
    rows = {name: table.to_pylist() for name, table in tables.items()}
    change(manifest, rows)
    for name, table in tables.items():
        pq.write_table(pa.Table.from_pylist(rows[name], table.schema), folder / f"{name}.parquet")
    finish(folder, manifest)


def interpolated(a, b, t):
    """A pose between two: straight for places and joints, the short way for the rotation."""
    pose = a + t * (b - a)
    q, r = a[3:7], b[3:7] * np.sign(a[3:7] @ b[3:7] or 1)
    angle = np.arccos(min(1.0, q @ r))
    if angle > 1e-9:
        pose[3:7] = (np.sin((1 - t) * angle) * q + np.sin(t * angle) * r) / np.sin(angle)
    return pose


def landscape(folder, count, families, **manifest):
    """A landscape of committed grasps and copies of them moved a little, with a random tree of connections.

    Up to 1,000 minima, all connections have paths; else only those between families.
    """
    table, told, rng = grasps(), metadata(), np.random.default_rng(3)
    poses = np.hstack([np.stack(table[name].to_numpy()) for name in ("translation_m", "rotation_wxyz", "joints")])
    energies = table["energy"].to_numpy()
    copied = np.arange(count) >= len(energies)
    of = np.arange(count) % len(energies)
    energy = energies[of] + copied * rng.uniform(0, 0.05, count)
    pose = poses[of]
    pose[:, :3] += copied[:, None] * rng.uniform(-1e-3, 1e-3, (count, 3))
    order = np.argsort(energy, kind="stable")
    energy, pose, of = energy[order], pose[order], of[order]

    family, edges, paths = list(range(families)), [], []
    for k in range(1, count):
        other = int(rng.integers(k if k < families else min(k, 4 * families)))
        if k >= families:
            family.append(family[other])
        height = energy[k] + rng.uniform(0.01, 0.2)
        edges.append({
            "a": other, "b": k, "height": height, "relative_barrier": height - energy[k], "length": 0.1, "chain_runs": 0, "evaluations": 0,
            "evidence": ("saddle", "path", "chain")[k % 3], "way": ("sliding", "regrasping")[k % 2],
        })
        if count <= 1000 or family[k] != family[other]:
            paths += [
                {"a": other, "b": k, "image": image, "coordinates": interpolated(pose[other], pose[k], image / (IMAGES - 1)),
                 "energy": max(energy[other], energy[k])}
                for image in range(IMAGES)
            ]
    minima = [
        {"id": k, "energy": energy[k], "coordinates": pose[k], "members": [k], "family": family[k], "labels": [],
         "label_counts": []}
        for k in range(count)
    ]

    whole, number, text = pa.uint64(), pa.float64(), pa.string()

    def schema(columns, maybe=()):
        return pa.schema([pa.field(name, kind, nullable=name in maybe) for name, kind in columns.items()])

    def items(kind):
        return pa.list_(pa.field("element", kind, nullable=False))

    coordinates = pa.list_(pa.field("element", number, nullable=False), pose.shape[1])
    numbers = {name: number for name in ("height", "relative_barrier", "length")}
    chains = {name: number for name in ("chain_forward", "chain_backward")}
    terms = [name.removeprefix("term_") for name in table.column_names if name.startswith("term_")]
    term_columns = {f"term_{name}": number for name in terms}
    schemas = {
        "minima": schema({"id": whole, "energy": number, "coordinates": coordinates, "members": items(whole),
                          "family": whole, "labels": items(text), "label_counts": items(whole)}),
        "edges": schema({"a": whole, "b": whole, **numbers, "evidence": text, "term": text, **chains, "chain_runs": whole,
                         "evaluations": whole, "way": text}, maybe=(*numbers, "term", *chains, "way")),
        "paths": schema({"a": whole, "b": whole, "image": whole, "coordinates": coordinates, "energy": number,
                         **term_columns}, maybe=term_columns),
    }
    folder.mkdir(parents=True)
    for name, rows in (("minima", minima), ("edges", edges), ("paths", paths)):
        head = {"format": "landscape", "schema_version": 1, "table": f"{name}.parquet"}
        described = schemas[name].with_metadata({"landscape": json.dumps(head)})
        pq.write_table(pa.Table.from_pylist(rows, described), folder / f"{name}.parquet")
    finish(folder, {
        "program_version": "0.0.0", "command": "made by a test", "seed": 0, "source": {"name": "", "content_hash": ""},
        "hand": told["hands"][0], "object": told["objects"][0], "scale": "\x011.0", "energy": told["energy"], "terms": terms,
        "settings": {"sameness": {"distance": "\x010.001"}}, "family_barrier": "\x010.05", "letting_go": None, "evidence": {},
        "counts": {"grasps": count, "minima": count, "families": families, "pairs": 0, "components": 0, "evaluations": 0}, "findings": {},
        "warnings": [], **manifest,
    })
    return folder


def mano(file):
    """A synthetic hand with the keys and shapes of the real MANO file: tubes around bones, all else small and random."""
    rng = np.random.default_rng(11)
    bones = [np.array([[0.05, 0, 0], [-0.03, 0, 0]])]
    fingers = [((-0.04, 0, side), (-1, 0, 0), length) for side, length in ((0.03, 1), (0.01, 1.1), (-0.032, 0.8), (-0.011, 1))]
    for start, along, length in [*fingers, ((0.02, -0.01, 0.035), (-0.6, -0.35, 0.72), 1)]:
        ends = np.cumsum([0, *np.array([0.04, 0.028, 0.022]) * length])[:, None] * np.array(along) / np.linalg.norm(along) + start
        bones += [ends[k : k + 2] for k in range(3)]
    parents = [0 if k % 3 == 0 else k for k in range(15)]
    vertices, faces, weights = [], [], []
    for link, (a, b) in enumerate(bones):
        rings, radius = (7, (0.012, 0.04)) if link == 0 else (6, (0.008, 0.008))
        along = (b - a) / np.linalg.norm(b - a)
        across = np.cross(along, [0, 1, 0])
        across /= np.linalg.norm(across)
        first = len(vertices)
        for share in np.linspace(0, 1, rings):
            narrow = 1 - 0.3 * (2 * share - 1) ** 2
            row = np.zeros(16)
            row[link] = 1
            if link:
                blend = 0.5 * (1 - share) ** 3
                row[link] -= blend
                row[parents[link - 1]] += blend
            for angle in np.arange(8) * np.pi / 4:
                out = across * np.cos(angle) * radius[1] + np.cross(along, across) * np.sin(angle) * radius[0]
                vertices.append(a + share * (b - a) + narrow * out)
                weights.append(row)
        corner = lambda ring, k, first=first: first + 8 * ring + k % 8
        for ring in range(rings - 1):
            for k in range(8):
                p, q, r, s = corner(ring, k), corner(ring, k + 1), corner(ring + 1, k), corner(ring + 1, k + 1)
                faces += [[p, q, s], [p, s, r]]
        last = rings - 1
        for k in range(1, 7):
            faces += [[corner(0, 0), corner(0, k + 1), corner(0, k)], [corner(last, 0), corner(last, k), corner(last, k + 1)]]
    # The real file has 778 vertices; those that are left are on no face.
    left = 778 - len(vertices)
    vertices += [[0.05, 0, 0]] * left
    weights += [np.eye(16)[0]] * left
    # Each joint is the middle of the first ring of its link.
    regressor = np.zeros((16, 778))
    for link in range(16):
        start = 0 if link == 0 else 56 + 48 * (link - 1)
        regressor[link, start : start + 8] = 0.125
    np.savez(
        file, v_template=np.array(vertices), f=np.array(faces, np.uint32), shapedirs=rng.uniform(-1e-3, 1e-3, (778, 3, 10)),
        posedirs=rng.uniform(-3e-4, 3e-4, (778, 3, 135)), J_regressor=regressor, weights=np.array(weights),
        kintree_table=np.array([[2**32 - 1, *parents], range(16)]), hands_components=np.linalg.qr(rng.uniform(-1, 1, (45, 45)))[0],
        hands_mean=np.where((np.arange(45) % 3 == 2) & (np.arange(45) < 36), 0.25, rng.uniform(-0.05, 0.05, 45)),
        hands_coeffs=rng.uniform(-1, 1, (60, 45)) * 1.2 / np.sqrt(1 + np.arange(45)),
    )
    return file
