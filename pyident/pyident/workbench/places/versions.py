"""Any two versions of the model side by side on the same logs."""

from functools import partial
from pathlib import Path
from typing import Any

from nicegui import ui

from pyident.workbench.places.tab import Tab


def show(page: Tab) -> None:
    """Two choices and, once both versions have been compared with the logs, their errors."""
    project = page.bench.project
    names = {i: f"{i}: {v.what if i else v.model}" for i, v in enumerate(project.versions)}
    pair = page.pair or (max(project.current - 1, 0), max(project.current, 1))
    with ui.row().classes("items-center gap-2"):
        for place, testid in enumerate(("version-before", "version-after")):
            ui.select(
                names,
                value=pair[place],
                label=("compare", "with")[place],
                on_change=lambda e, p=place: page.choose(*[e.value if i == p else pair[i] for i in (0, 1)]),
            ).classes("w-48").props(f'data-testid="{testid}" dense')
        ui.button("Compare them", on_click=partial(page.act, partial(_compare, page, pair))).props(
            'data-testid="compare-versions" flat dense no-caps'
        ).set_enabled("compare" not in page.bench.jobs)
    both = [page.bench.result("compare", number) for number in pair]
    if page.pair and all(both):
        _table(both[0], both[1], [names[number] for number in pair])


def _compare(page: Tab, pair: tuple[int, int]) -> None:
    """Compare what has not been compared yet, one version after the other."""
    page.choose(*pair)
    page.bench.compare_all([n for n in dict.fromkeys(pair) if page.bench.result("compare", n) is None])


def _table(before: Any, after: Any, names: list[str]) -> None:
    rows = []
    for old, new in zip(before.comparison.logs, after.comparison.logs, strict=True):
        for kind in ("equations", "simulation"):
            for name, error in getattr(old, kind).items():
                late = getattr(new, kind).get(name)
                if late is not None:
                    rows.append(
                        {
                            "log": Path(old.log).name,
                            "signal": f"{name} ({'equation' if kind == 'equations' else 'simulated'})",
                            "before": f"{error.rmse:.4g}",
                            "after": f"{late.rmse:.4g}",
                            "floor": f"{late.floor:.4g}",
                            "unit": error.unit,
                        }
                    )
    labels = {
        "log": "log",
        "signal": "signal",
        "before": names[0],
        "after": names[1],
        "floor": "floor",
        "unit": "",
    }
    columns = [{"name": n, "label": label, "field": n, "align": "left"} for n, label in labels.items()]
    ui.table(rows=rows, columns=columns, pagination=12).props('data-testid="versions-table" dense flat')
