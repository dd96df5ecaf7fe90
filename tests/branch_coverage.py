"""Share of the branches of each room of pyident that the tests took: branch_coverage.py FILE.json."""

import json
import sys
from collections import Counter
from pathlib import Path, PurePath

GOAL = 90.0  # percent


def main(path: str) -> int:
    branches, taken = Counter(), Counter()
    for name, file in json.loads(Path(path).read_text())["files"].items():
        inside = PurePath(name).parts
        if "pyident" not in inside:
            continue  # a study, in a process that was started elsewhere
        inside = inside[len(inside) - inside[::-1].index("pyident") :]
        room = inside[0] if len(inside) > 1 else "front door"
        branches[room] += file["summary"]["num_branches"]
        taken[room] += file["summary"]["covered_branches"]
    for room in sorted(branches, key=lambda room: taken[room] / max(branches[room], 1)):
        print(
            f"{_percent(taken[room], branches[room]):6.1f} %  {taken[room]:5} of {branches[room]:5}  {room}"
        )
    total = _percent(taken.total(), branches.total())
    print(f"{total:6.1f} %  {taken.total():5} of {branches.total():5}  pyident (goal: {GOAL:g} %)")
    return int(total < GOAL)


def _percent(part: int, whole: int) -> float:
    return 100 * part / whole if whole else 100.0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
