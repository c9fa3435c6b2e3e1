"""The loss of a small neural network as an energy of its own program, in the binary protocol.

    landscape surface --command "python3 data/energies/neural_network.py" --protocol binary --region=-3:3x9

The network has two inputs, two hidden units (tanh) and one output (logistic), and learns the exclusive or: its loss is the
mean cross-entropy over the four cases plus a term that keeps the weights finite. Its nine weights are the coordinates. The
loss does not change if the hidden units are exchanged or the signs around one are turned, so every minimum has up to
eight copies.

A question is nine numbers of 64 bits on standard input, and an answer ten on standard output: the loss and its gradient.
"""

import math
import struct
import sys

CASES = (((-1.0, -1.0), 0.0), ((-1.0, 1.0), 1.0), ((1.0, -1.0), 1.0), ((1.0, 1.0), 0.0))
DECAY = 0.01
WEIGHTS = 9


def loss_and_gradient(w):
    loss = 0.5 * DECAY * sum(k * k for k in w)
    gradient = [DECAY * k for k in w]
    for (a, b), wanted in CASES:
        first = math.tanh(w[0] * a + w[1] * b + w[2])
        second = math.tanh(w[3] * a + w[4] * b + w[5])
        output = w[6] * first + w[7] * second + w[8]
        # ln(1 + exp(output)) - wanted * output, without overflow.
        loss += (max(output, 0.0) + math.log1p(math.exp(-abs(output))) - wanted * output) / len(CASES)
        if output >= 0.0:
            chance = 1.0 / (1.0 + math.exp(-output))
        else:
            chance = math.exp(output) / (1.0 + math.exp(output))
        error = (chance - wanted) / len(CASES)
        for hidden, place, weight in ((first, 0, w[6]), (second, 3, w[7])):
            back = error * weight * (1.0 - hidden * hidden)
            gradient[place] += back * a
            gradient[place + 1] += back * b
            gradient[place + 2] += back
        gradient[6] += error * first
        gradient[7] += error * second
        gradient[8] += error
    return loss, gradient


question = struct.Struct("<9d")
answer = struct.Struct("<10d")
while True:
    data = sys.stdin.buffer.read(question.size)
    if len(data) < question.size:
        break
    loss, gradient = loss_and_gradient(question.unpack(data))
    sys.stdout.buffer.write(answer.pack(loss, *gradient))
    sys.stdout.buffer.flush()
