"""Which of two hands grasps a bottle in more ways? Grasps, and effective numbers of kinds at equal sample size.

python two_hands.py [FOLDER]    writes FOLDER/two_hands.png, and FOLDER/human.grasps.html to look at the grasps in a browser
"""

import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import landscape as ls

folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
bottle = ls.Object("bottle_round")
names = ["human", "gripper_three_finger"]
grasps = [ls.synthesize(ls.Hand(name), bottle, 48, seed=1, out=folder / f"{name}.parquet") for name in names]
for found in grasps:
    print(f"{found}: epsilon {np.median(found.epsilon):.2f}, energy {np.median(found.energy):.3f} in the median")

told = ls.diversity(*grasps, out=folder / "two_hands")
print(told["answer"])

# Effective numbers of Hill: of all kinds, of common ones, of the most common ones. A set that is too small for a measure has none.
measures = [measure for measure in told["measures"] if all(measure["sets"])]
figure, axes = plt.subplots(1, len(measures), figsize=(5 * len(measures), 4), layout="constrained", squeeze=False)
for axis, measure in zip(axes[0], measures):
    for place, (name, numbers) in enumerate(zip(names, measure["sets"])):
        values = np.array([number["value"] for number in numbers])
        low, high = np.array([number["interval"] for number in numbers]).T
        axis.errorbar(
            np.arange(len(values)) + 0.12 * place, values, [np.maximum(values - low, 0), np.maximum(high - values, 0)],
            fmt="o", capsize=4, label=name,
        )
    axis.set(title=f"{measure['of']}, {measure['grasps']} grasps each", ylabel="effective number of kinds", ylim=(0, None))
    axis.set_xticks(range(3), ["all", "common", "most common"])
    axis.legend()
figure.savefig(folder / "two_hands.png", dpi=120)
grasps[0].report(folder / "human.grasps.html")
