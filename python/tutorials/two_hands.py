"""Which of two hands grasps a bottle in more ways? Grasps, their types and effective numbers of kinds.

python two_hands.py [FOLDER]    writes FOLDER/human.grasps.html
"""

import sys
from pathlib import Path

import landscape as ls

folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
bottle = ls.Object("bottle_round")
right, left = ls.Hand("human"), ls.Hand("human", mirror=True)
grasps = [ls.synthesize(hand, bottle, 32, seed=1, keep="all") for hand in (right, left)]
for found in grasps:
    types = found.labels()
    print(found, sorted(set(types["label_auto"])), f"{found.passes().mean():.0%} pass the strict filter")
told = ls.diversity(*grasps)
print(sorted(told))
grasps[0].report(folder / "human.grasps.html")
