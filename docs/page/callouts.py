#!/usr/bin/env python3
"""Cuts parts out of the pictures of this folder and numbers what docs/pictures.md explains: docs/page/callouts.py

Needs Pillow 10.1 or later (pip install pillow). screenshots.sh calls this. The places below are those of the present pictures, so look at the results after the
page has changed.
"""

import pathlib

from PIL import Image, ImageDraw, ImageFont

HERE = pathlib.Path(__file__).resolve().parent
INK = (29, 29, 36)
GROUND = (243, 244, 246)
RADIUS = 15
SCALE = 4  # drawn larger and made smaller, so that edges are smooth

# Of each new picture: the picture, its parts (left, top, right, bottom), which stand side by side, the height of what is added
# below, and for each number the place of its circle and the place that it points to, in pixels of the picture.
PICTURES = {
    "surface_numbered": (
        "surface",
        [(16, 130, 424, 678), (840, 130, 1424, 678)],
        0,
        [
            ((205, 640), (160, 620)),
            ((320, 298), (292, 339)),
            ((189, 270), (238, 228)),
            ((985, 360), (1032, 400)),
        ],
    ),
    "tree_numbered": (
        "families",
        [(16, 130, 542, 678), (956, 130, 1424, 678)],
        0,
        [
            ((346, 650), (245, 607)),
            ((46, 360), (92, 368)),
            ((226, 383), (301, 352)),
            ((1330, 360), (1235, 380)),
        ],
    ),
    "level_numbered": (
        "families",
        [(16, 130, 952, 678)],
        0,
        [
            ((52, 490), (52, 430)),
            ((166, 602), (230, 568)),
            ((456, 602), (345, 530)),
            ((118, 470), (100, 408)),
        ],
    ),
    "trust_numbered": (
        "families",
        [(0, 62, 1180, 98)],
        30,
        [((x, 111), (x, 91)) for x in (27, 234, 496)],
    ),
    "way_numbered": (
        "way",
        [(16, 130, 1424, 1030)],
        0,
        [
            ((130, 600), (227, 540)),
            ((1330, 795), (1286, 795)),
            ((365, 942), (330, 968)),
            ((720, 840), (643, 862)),
            ((860, 1005), (895, 1024)),
        ],
    ),
}


def joined(name, parts, below):
    """The parts side by side, and a function from a place in the picture to the place here."""
    picture = Image.open(HERE / f"{name}.webp").convert("RGB")
    size = (sum(right - left for left, _, right, _ in parts), parts[0][3] - parts[0][1] + below)
    whole = Image.new("RGB", size, GROUND)
    starts, x = [], 0
    for part in parts:
        whole.paste(picture.crop(part), (x, 0))
        starts.append(x)
        x += part[2] - part[0]

    def here(place):
        k = next(k for k, (left, _, right, _) in enumerate(parts) if left <= place[0] < right)
        return (place[0] - parts[k][0] + starts[k], place[1] - parts[k][1])

    return whole, here


def numbered(name, parts, below, callouts):
    picture, here = joined(name, parts, below)
    layer = Image.new("RGBA", (SCALE * picture.width, SCALE * picture.height), (*INK, 0))
    draw = ImageDraw.Draw(layer)
    font = ImageFont.load_default(SCALE * 19)
    for number, places in enumerate(callouts, 1):
        middle, target = [tuple(SCALE * part for part in here(place)) for place in places]
        draw.line([middle, target], fill="white", width=SCALE * 6)
        draw.line([middle, target], fill=INK, width=SCALE * 2)
        for (x, y), radius, edge in [(target, 4, 1), (middle, RADIUS, 2)]:
            radius *= SCALE
            draw.ellipse([x - radius, y - radius, x + radius, y + radius], fill=INK, outline="white", width=SCALE * edge)
        draw.text(middle, str(number), fill="white", font=font, anchor="mm", stroke_width=SCALE // 2, stroke_fill="white")
    layer = layer.resize(picture.size, Image.Resampling.LANCZOS)
    picture.paste(layer, (0, 0), layer)
    return picture


for made, what in PICTURES.items():
    numbered(*what).save(HERE / f"{made}.webp", quality=82, method=6)
