"""Parts of the reference that the code knows best: effects, units, metrics, the front door's names."""

import inspect
from collections.abc import Callable, Iterator
from typing import Any

from docutils import nodes
from sphinx.util.docutils import SphinxDirective

import pyident
from flexmodels.effects import BASE, CATALOGUE
from pyident.logs.units import FACTORS
from pyident.rules.rules import every_threshold
from pyident.sweep.metrics import METRICS


def setup(app: Any) -> dict[str, bool]:
    app.add_directive("generated", Generated)
    app.add_directive("public-api", PublicApi)
    return {"parallel_read_safe": True}


class Generated(SphinxDirective):
    """`{generated} WHAT`: a table of it."""

    required_arguments = 1

    def run(self) -> list[nodes.Node]:
        head, *rows = _TABLES[self.arguments[0]]()
        return self.parse_text_to_nodes(
            "\n".join([_line(head), _line(["---"] * len(head)), *map(_line, rows)])
        )


class PublicApi(SphinxDirective):
    """`{public-api} MODULE`: functions, then classes, of its `__all__`."""

    required_arguments = 1

    def run(self) -> list[nodes.Node]:
        module = self.arguments[0]
        values = [(name, getattr(pyident, name)) for name in pyident.__all__]
        functions = [f".. autofunction:: {module}.{name}" for name, v in values if not inspect.isclass(v)]
        classes = [
            f".. autoclass:: {module}.{name}\n   :members:" for name, v in values if inspect.isclass(v)
        ]
        text = "```{eval-rst}\n" + "\n\n".join([*functions, *classes]) + "\n```\n"
        return self.parse_text_to_nodes(text)


def _line(cells: list[str]) -> str:
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"


def _effects() -> Iterator[list[str]]:
    yield ["effect", "what it is", "parameters", "needs", "source"]
    for name, effect in sorted(CATALOGUE.items(), key=lambda item: (item[0] not in BASE, item[0])):
        parameters = ", ".join(f"`{p.name}` [{p.unit}]" for p in effect.parameters)
        yield [f"`{name}`", effect.title, parameters, effect.needs, effect.citation]


def _units() -> Iterator[list[str]]:
    yield ["unit", "in SI"]
    for unit, factor in FACTORS.items():
        yield [f"`{unit}`", f"{factor:.10g}"]


def _metrics() -> Iterator[list[str]]:
    yield ["metric", "what"]
    for name, metric in METRICS.items():
        yield [f"`{name}`", (inspect.getdoc(metric) or "").splitlines()[0]]


def _thresholds() -> Iterator[list[str]]:
    yield ["threshold", "value", "of", "why", "fixed on"]
    for line in every_threshold():
        value = f"{line.value:.4g}" if isinstance(line.value, float) else str(line.value)
        yield [f"`{line.name}`", value, line.of, line.why, line.fixed_on]


_TABLES: dict[str, Callable[[], Iterator[list[str]]]] = {
    "effects": _effects,
    "units": _units,
    "metrics": _metrics,
    "thresholds": _thresholds,
}
