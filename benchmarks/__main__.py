"""All benchmarks, and one table of them: python -m benchmarks -o out"""

import argparse
import os
import platform
import subprocess
import sys
from datetime import date
from pathlib import Path

import pandas as pd
from benchmarks.measure import ROOT, THREADS
from benchmarks.parameter_study import speedups
from benchmarks.startup import PEER

RUNS = ("startup", "regressor", "solve", "simulation", "parameter_study")


def machine() -> str:
    """Processor, cores, system and interpreter."""
    described = Path("/proc/cpuinfo")
    lines = described.read_text().splitlines() if described.exists() else []
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    processor = names[0] if names else platform.processor() or platform.machine()
    return f"{processor}, {os.cpu_count()} cores, {platform.system()}, Python {platform.python_version()}"


def table(out: Path) -> pd.DataFrame:
    """What each tool reached: speed or seconds, memory, and how many times ours is better (ratio)."""
    started = pd.read_csv(out / "startup.csv")
    peer = started.loc[started["what"] == PEER, "CPU [s]"].iloc[0]
    rows = [("start [CPU s]", row["what"], row["CPU [s]"], None, peer / row["CPU [s]"])
            for _, row in started.iterrows()]  # fmt: skip
    Phi = pd.read_csv(out / "regressor.csv").query("joints == 4")
    speed = dict(zip(Phi["tool"], Phi["samples per second"], strict=True))
    ours = speed["pyident, compiled"]
    rows += [("Phi of four_link [samples/s]", tool, x, None, ours / x) for tool, x in speed.items()]
    solved = pd.read_csv(out / "solve.csv")
    seconds = solved.query("tool == 'ours'")["seconds"].iloc[0]
    for _, row in solved.iterrows():
        ratio = None if "disk" in row["tool"] else row["seconds"] / seconds
        what = f"build and solve {row['samples']} samples [s]"
        rows.append((what, row["tool"], row["seconds"], row["peak MB"], ratio))  # pyright: ignore[reportArgumentType]
    simulated = pd.read_csv(out / "simulation_summary.csv")
    for name, group in simulated.groupby("case", sort=False):
        own = group.loc[group["tool"] == "flexident FMU", "speed"].iloc[0]
        what = f"simulation, {name} [s per CPU s]"
        rows += [
            (what, f"{row['tool']} ({row['verdict']})", row["speed"], None, own / row["speed"])
            for _, row in group.iterrows()
        ]
    study = pd.read_csv(out / "parameter_study.csv")
    faster = speedups(study)["all"]
    for workers, seconds in study.groupby("workers")["all [s]"].median().items():
        rows.append(("200 runs of four_link [s]", f"{workers} workers", seconds, None, faster[workers]))
    return pd.DataFrame(rows, columns=["what", "tool", "figure", "peak MB", "times ours is better"])


def markdown(found: pd.DataFrame) -> str:
    """The table and the machine it was made on."""
    lines = [
        f"{date.today()}, {machine()}",
        "",
        "| " + " | ".join(found) + " |",
        "|---" * len(found.columns) + "|",
    ]
    for row in found.itertuples(index=False):
        cells = ("" if pd.isna(x) else f"{x:.4g}" if isinstance(x, float) else str(x) for x in row)
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-o", "--out", type=Path, default=Path("out/bench"), help="folder of the results")
    out = parser.parse_args().out.resolve()
    environment = os.environ | dict.fromkeys(THREADS, "1")
    for name in RUNS:
        print(f"benchmark of {name}", file=sys.stderr)
        command = [sys.executable, "-m", f"benchmarks.{name}", "-o", str(out)]
        subprocess.run(command, cwd=ROOT, env=environment, check=True)
    found = table(out)
    found.to_csv(out / "table.csv", index=False)
    (out / "table.md").write_text(markdown(found), encoding="utf-8")
    print("\n" + markdown(found))
    return 0


if __name__ == "__main__":
    sys.exit(main())
