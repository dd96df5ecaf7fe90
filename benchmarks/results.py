"""What every benchmark does alike: its command line, its table, its figure."""

import argparse
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pandas as pd


def command(doc: str | None) -> argparse.ArgumentParser:
    """A command line with the option --out."""
    parser = argparse.ArgumentParser(description=doc, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("-o", "--out", type=Path, default=Path("out"), help="folder of table and figure")
    return parser


def keep(table: pd.DataFrame, name: str, out: Path, figure: Callable[[pd.DataFrame, Path], None]) -> None:
    """Print the table; write name.csv and name.png."""
    out.mkdir(parents=True, exist_ok=True)
    table.to_csv(out / f"{name}.csv", index=False)
    figure(table, out / f"{name}.png")
    print(table.to_string(index=False, float_format="{:.4g}".format))


@contextmanager
def drawn(path: Path, columns: int = 1) -> Iterator[list[Any]]:
    """Axes beside each other, written to `path` at the end."""
    import matplotlib.pyplot as plt

    fig, axes = plt.subplots(1, columns, figsize=(2 + 4 * columns, 4), layout="constrained", squeeze=False)
    yield list(axes[0])
    for ax in axes[0]:
        ax.grid(alpha=0.3)
        if ax.get_legend_handles_labels()[0]:
            ax.legend()
    fig.savefig(path, dpi=150)
    plt.close(fig)
