"""A hand and an object of your own: a URDF file, a mesh in millimetres, their grasps, and the landscape between these.

python own_hand_and_object.py [FOLDER]    writes FOLDER/claw.svg
"""

import sys
from pathlib import Path

import landscape as ls

folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
files = Path(__file__).parent / "claw"

hand = ls.Hand(files / "claw.urdf")
bar = ls.Object(files / "bar.obj", scale=0.001)

# What was derived: look at it before you trust the grasps.
print(hand, "with the digits", hand.digits)
for name, (low, high) in zip(hand.joint_names, hand.limits):
    print(f"  {name}: {low:.2f} to {high:.2f} rad")
print(f"{bar}: {1000 * bar.radius_m:.0f} mm from its centre to its farthest corner, {1000 * bar.mass_kg:.0f} g")
for note in [*hand.notes, *bar.notes]:
    print(note)

grasps = ls.synthesize(hand, bar, 5, seed=1)
held = grasps.stability()
print(f"{len(grasps)} of 5 chains gave a grasp, and {int(held.stable.sum())} of these hold in the drop test")
print(f"epsilon from {grasps.epsilon.min():.2f} to {grasps.epsilon.max():.2f}")

land = grasps.build(neighbours=1)
print(land)
way = land.path(0, 1)
most = max(way.terms, key=lambda name: way.terms[name][way.top] - way.terms[name][0])
print(f"from the best grasp to the next: up to {way.height:.3f}, most of it by the term {most}")
land.draw(folder / "claw.svg", examples=4)
