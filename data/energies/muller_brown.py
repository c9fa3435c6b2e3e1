"""The Müller-Brown surface as an energy of its own program.

    landscape surface --command "python3 data/energies/muller_brown.py" --region=-1.5:1,-0.3:1.8

One question a line on standard input, one answer a line on standard output, until the input ends. To map a function of
your own, replace `energy_and_gradient`; leave "gradient" out of the answer if you have none.
"""

import json
import math
import sys

HEIGHT = (-200.0, -100.0, -170.0, 15.0)
A = (-1.0, -1.0, -6.5, 0.7)
B = (0.0, 0.0, 11.0, 0.6)
C = (-10.0, -10.0, -6.5, 0.7)
X = (1.0, 0.0, -0.5, -1.0)
Y = (0.0, 0.5, 1.5, 1.0)


def energy_and_gradient(x, y):
    energy, slope_x, slope_y = 0.0, 0.0, 0.0
    for height, a, b, c, x0, y0 in zip(HEIGHT, A, B, C, X, Y):
        dx, dy = x - x0, y - y0
        value = height * math.exp(a * dx * dx + b * dx * dy + c * dy * dy)
        energy += value
        slope_x += value * (2.0 * a * dx + b * dy)
        slope_y += value * (b * dx + 2.0 * c * dy)
    return energy, [slope_x, slope_y]


for line in sys.stdin:
    question = json.loads(line)
    try:
        energy, gradient = energy_and_gradient(*question["x"])
        answer = {"energy": energy, "gradient": gradient}
    except OverflowError:
        # Far up the wall: outside the domain.
        answer = {"energy": None}
    print(json.dumps(answer), flush=True)
