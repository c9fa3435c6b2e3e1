"""A published data set of grasps: read, judged and named. DexGraspNet's format; the other formats are read in the same way.

python published_grasps.py [FOLDER [GRASPS HAND OBJECT]]    writes FOLDER/published_grasps.png

GRASPS is a file of the data set, HAND the description of its hand, OBJECT the mesh of its object. Without them the
script writes such a file first, with grasps of its own.
"""

import sys
from collections import Counter
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import landscape as ls

folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
if len(sys.argv) > 4:
    file, hand, thing = Path(sys.argv[2]), ls.Hand(sys.argv[3]), ls.Object(sys.argv[4])
else:
    hand, thing = ls.Hand("human"), ls.Object("bottle_round")
    mine = ls.synthesize(hand, thing, 40, seed=2, keep="all", steps=1)
    file = mine.export(folder / "grasps.npy", format="dexgraspnet")

grasps = ls.import_grasps(file, hand, thing)
print(grasps, *grasps.warnings, sep="\n")
for hand_name, object_name, scale, count in grasps.populations:
    print(f"  {count} grasps of {hand_name} on {object_name} at scale {scale:.3g}")

judged = grasps.judgement
strict = grasps.passes("strict")
gap, depth = 1000 * judged.gap_m, 1000 * judged.deepest_m
print(f"{strict.mean():.0%} pass the strict filter; the farthest contact is {np.median(gap):.1f} mm away in the median")
verdicts = np.array([reason or "passes" for reason in judged.objection])
print(dict(Counter(verdicts.tolist()).most_common()))
types = Counter(name or "no type" for name in grasps.labels()["label_auto"])

figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4.2), layout="constrained")
for verdict, count in Counter(verdicts.tolist()).most_common():
    chosen = verdicts == verdict
    left.scatter(gap[chosen], depth[chosen], s=14, marker="*" if verdict == "passes" else "o", label=f"{verdict}: {count}")
left.axvline(2, c="grey", lw=0.8, ls="--")
left.axhline(2, c="grey", lw=0.8, ls="--")
left.set(xlabel="farthest contact from the surface (mm)", ylabel="deepest point in the object (mm)", title="Strict filter")
left.legend()
names, counts = zip(*types.most_common(12))
right.barh(range(len(names)), counts, color="tab:blue")
right.set(yticks=range(len(names)), yticklabels=names, xlabel="grasps", title="Types in the GRASP taxonomy")
right.invert_yaxis()
figure.suptitle(file.name)
figure.savefig(folder / "published_grasps.png", dpi=120)
