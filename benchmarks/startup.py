"""How long it takes to start: `pyident --help` and `import pyident`, beside `import numpy, pandas`.

CPU time of a fresh interpreter, less that of one that does nothing; the least of several runs, the cases in
turn, so that a busy moment hits them alike. A machine's load cancels in the ratio to NumPy and pandas, which
every user of the package loads in the end. Files are read once before, so the disk is not measured.
"""

import argparse
import os
import subprocess
import sys
from pathlib import Path

import pandas as pd
from benchmarks.measure import ROOT

NOTHING, PEER = "python -c pass", "import numpy, pandas"
CASES = {
    NOTHING: ("-c", "pass"),
    PEER: ("-c", "import numpy, pandas"),
    "pyident --help": ("-m", "pyident", "--help"),
    "import pyident": ("-c", "import pyident"),
    "first use of identify and read_log": ("-c", "import pyident; pyident.identify, pyident.read_log"),
}
GOALS = {"pyident --help": 0.25, "import pyident": 0.5}  # [s] above a bare interpreter, on a quiet machine


def cpu_seconds(arguments: tuple[str, ...]) -> float:
    """User and system time of one interpreter [s]; on Windows, which does not tell, zero."""
    before = os.times()
    subprocess.run([sys.executable, *arguments], cwd=ROOT, check=True, stdout=subprocess.DEVNULL)
    after = os.times()
    return sum(after[i] - before[i] for i in (2, 3))  # of children


def measured(repeats: int) -> pd.DataFrame:
    """Per case: CPU above a bare interpreter [s], ratio to NumPy and pandas, goal [s]."""
    least = {name: cpu_seconds(arguments) for name, arguments in CASES.items()}
    for _ in range(repeats):
        for name, arguments in CASES.items():
            least[name] = min(least[name], cpu_seconds(arguments))
    above = {name: least[name] - least[NOTHING] for name in CASES if name != NOTHING}
    rows = [(name, x, x / above[PEER], GOALS.get(name)) for name, x in above.items()]
    return pd.DataFrame(rows, columns=["what", "CPU [s]", "ratio to numpy, pandas", "goal [s]"])


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])  # pyright: ignore[reportOptionalMemberAccess]
    parser.add_argument("-o", "--out", type=Path, default=Path("out/bench"), help="folder of the results")
    parser.add_argument("--repeats", type=int, default=9)
    arguments = parser.parse_args()
    found = measured(arguments.repeats)
    arguments.out.mkdir(parents=True, exist_ok=True)
    found.to_csv(arguments.out / "startup.csv", index=False)
    print(found.to_string(index=False, float_format="%.2f", na_rep=""))
    return 0


if __name__ == "__main__":
    sys.exit(main())
