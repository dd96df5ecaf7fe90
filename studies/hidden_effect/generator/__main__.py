"""The generator's command."""

import argparse
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from itertools import repeat
from pathlib import Path

from . import Case, case_list, cases_of, generate
from . import __doc__ as about


def main(arguments: Sequence[str] | None = None) -> None:
    """The command; prints the ids of what it has written."""
    parser = argparse.ArgumentParser(prog="python -m studies.hidden_effect.generator", description=about)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--cases", default="all", help="all, or with commas: null, LAW, LAW@JOINT, LAW+LAW")
    parser.add_argument("--robot", default="four_link", help="a shipped robot or a file")
    parser.add_argument("--amplitude", type=float, default=1.0, help="1 is strong, 0.25 is faint")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("-o", "--output", type=Path, required=True)
    a = parser.parse_args(arguments)
    if a.cases == "all":
        cases = case_list(a.seed, a.robot, amplitude=a.amplitude)
    else:
        cases = cases_of(a.cases.split(","), a.seed, a.robot, a.amplitude)
    with ProcessPoolExecutor(a.jobs) as pool:
        for done in pool.map(_generate, cases, repeat(a.output)):
            print(done, flush=True)


def _generate(case: Case, folder: Path) -> str:
    generate(case, folder)
    return case.id


if __name__ == "__main__":
    main()
