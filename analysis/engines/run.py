"""How often Rapier and MuJoCo agree on the published tests: writes figures/engines.md.

    python analysis/engines/run.py data/grasps.parquet theirs.parquet --grasps 30

needs the Python package and `pip install mujoco`. Of each set the given number of grasps is taken, evenly from its rows. Outcomes
are kept in target/engines.csv, so that a stopped run goes on.
"""

import argparse
import csv
import math
from pathlib import Path
from typing import NamedTuple

TESTS = (
    "drop", "dexgraspbench", "dexgraspbench-hard", "dexgraspnet", "graspqp", "graspqp-all", "gendexgrasp", "graspdatagen",
)
KEPT = Path("target/engines.csv")
#: Share of agreement that is asked for.
ASKED = 0.9


class Pair(NamedTuple):
    """One grasp in one test: the reasons of both engines."""

    set: str
    test: str
    id: int
    rapier: str
    mujoco: str


def wilson(successes: int, number: int) -> str:
    """A share in per cent with its 95 % interval (E. B. Wilson, J. Am. Stat. Assoc. 22, 209 (1927))."""
    z = 1.959963984540054
    share = successes / number
    middle = (share + z * z / (2 * number)) / (1 + z * z / number)
    half = z / (1 + z * z / number) * math.sqrt(share * (1 - share) / number + z * z / (4 * number * number))
    return f"{100 * share:.0f} [{100 * (middle - half):.0f}, {100 * (middle + half):.0f}]"


def row(name: str, pairs: list[Pair]) -> str:
    """A row of the table."""
    number = len(pairs)
    held = [[getattr(pair, engine) == "held" for pair in pairs] for engine in ("rapier", "mujoco")]
    both = sum(one == other for one, other in zip(*held))
    only = [sum(a and not b for a, b in zip(one, other)) for one, other in (held, held[::-1])]
    shares = [f"{100 * sum(each) / number:.0f}" for each in held]
    agree = wilson(both, number)
    return f"| {name} | {number} | {' | '.join(shares)} | {agree if both >= ASKED * number else f'**{agree}**'} | {only[0]} | {only[1]} |"


def table(pairs: list[Pair], sets: list[str]) -> str:
    """The tables: all sets together, then each."""
    head = (
        "| test | grasps | held in Rapier, % | held in MuJoCo, % | agreement, % | only Rapier holds | only MuJoCo holds |\n"
        "|---|---|---|---|---|---|---|\n"
    )
    parts = []
    for title, chosen in [("All grasps", sets), *((name, [name]) for name in sets)]:
        of_these = [pair for pair in pairs if pair.set in chosen]
        rows = [(test, [pair for pair in of_these if pair.test == test]) for test in TESTS]
        parts.append(f"## {title}\n\n{head}" + "\n".join(row(*each) for each in rows if each[1]) + "\n")
    return "\n".join(parts)


def read(file: Path) -> dict[tuple[str, str, int], Pair]:
    """The outcomes that are kept."""
    if not file.exists():
        return {}
    with file.open(newline="", encoding="utf-8") as lines:
        pairs = [Pair(set, test, int(id), *reasons) for set, test, id, *reasons in csv.reader(lines)]
    return {(pair.set, pair.test, pair.id): pair for pair in pairs}


def write(file: Path, kept: dict[tuple[str, str, int], Pair]) -> None:
    """Keeps outcomes."""
    file.parent.mkdir(parents=True, exist_ok=True)
    with file.open("w", newline="", encoding="utf-8") as lines:
        csv.writer(lines).writerows(kept.values())


def main() -> None:
    import landscape as ls

    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sets", nargs="+", type=Path)
    parser.add_argument("--grasps", type=int, default=30, help="grasps of each set")
    parser.add_argument("--output", type=Path, help="the file to write; by default the tables are printed")
    given = parser.parse_args()
    pairs = []
    kept = read(KEPT)
    for file in given.sets:
        every = ls.Grasps.read(file)
        step = max(len(every) // given.grasps, 1)
        grasps = every[::step][: given.grasps]
        for test in TESTS:
            for number, id in enumerate(grasps.id):
                key = (file.stem, test, int(id))
                if key not in kept:
                    one = grasps[number : number + 1]
                    ours, theirs = one.stability(test).column("stable_reason"), one.stability_in_mujoco(test)
                    kept[key] = Pair(*key, ours[0], theirs.stable_reason[0])
                    write(KEPT, kept)
                pairs.append(kept[key])
            print(row(f"{file.stem}, {test}", pairs[-len(grasps) :]), flush=True)
    text = table(pairs, [file.stem for file in given.sets])
    if given.output is None:
        print(text)
    else:
        given.output.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
