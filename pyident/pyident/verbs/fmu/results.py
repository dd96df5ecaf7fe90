"""What `identify`, `compare` and `diagnose` return of an FMU of any origin."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from pyident.rules.greybox import GREYBOX
from pyident.verbs.result import Result
from pyident.verbs.terminal.table import table
from pyident.verbs.text import Text, finite, half_interval, wrapped

if TYPE_CHECKING:
    import pandas as pd

    from pyident.greybox.output_error import OutputError
    from pyident.greybox.recording import Recording
    from pyident.greybox.residual import Finding, Shown


@dataclass(frozen=True, repr=False)
class FmuFit(Result):
    """Parameters of an FMU that follow from logs."""

    model: str
    recordings: "tuple[Recording, ...]"
    fit: "OutputError"
    notes: tuple[str, ...]

    @property
    def values(self) -> dict[str, float]:
        """Name -> value, as `compare` and `simulate` take them."""
        return self.fit.values

    def headline(self) -> str:
        return f"{self.model}: {len(self.fit.estimates)} parameters by output error"

    def to_dict(self) -> dict[str, Any]:
        parameters = {
            e.free.name: {
                "value": e.value,
                "std": finite(e.std),
                "unit": e.free.unit,
                "start": e.free.start,
                "bounds": [finite(e.free.low), finite(e.free.high)],
                "identifiable": "alone" if e.determined else "no",
                "slope": e.slope,
            }
            for e in self.fit.estimates
        }
        residuals = _errors(self.recordings, self.fit.residuals)
        return {"parameters": parameters, "residuals": residuals, "notes": list(self.notes)}

    def to_frame(self) -> "pd.DataFrame":
        """A row per parameter: value, std, unit, start, bounds, identifiable, slope."""
        import pandas as pd

        rows = self.to_dict()["parameters"]
        return pd.DataFrame.from_dict(rows, orient="index").rename_axis("parameter")

    def summary(self) -> Text:
        rows = [
            (
                e.free.name,
                f"{e.value:.6g}",
                half_interval(e.std),
                e.free.unit,
                "" if e.determined else "the logs do not tell it by itself",
            )
            for e in self.fit.estimates
        ]
        heads = ("parameter", "value", "± 95 %", "unit", "")
        found = table(heads, rows, numbers=(1, 2))
        said = [found, self._slopes(), self._as_options(), _table_of(self.recordings, self.fit.residuals)]
        return Text("\n".join(said))

    def _as_options(self) -> str:
        """The values as other commands take them."""
        return "with them: " + " ".join(f"--set {name}={value:.9g}" for name, value in self.values.items())

    def _slopes(self) -> str:
        """How the outputs' slopes were got."""
        ways = {
            e.slope: [o.free.name for o in self.fit.estimates if o.slope == e.slope]
            for e in self.fit.estimates
        }
        if len(ways) == 1:
            return f"slopes by {next(iter(ways))}"
        return wrapped("; ".join(f"slopes by {way}: {', '.join(names)}" for way, names in ways.items()))


@dataclass(frozen=True, repr=False)
class FmuCompared(Result):
    """Where an FMU fails on logs; residuals (N, S) per recording."""

    model: str
    recordings: "tuple[Recording, ...]"
    residuals: tuple[np.ndarray, ...]
    notes: tuple[str, ...]

    def headline(self) -> str:
        listed = [(o, e) for log in self.errors.values() for o, e in log.items()]
        moving = [(e["nrmse_percent"], o) for o, e in listed if e["nrmse_percent"] is not None]
        if moving:
            percent, name = max(moving)
            return f"{self.model}: it misses {name} most, by {percent:.3g} % of the signal"
        rmse, name, unit = max((e["rmse"], o, e["unit"]) for o, e in listed)
        return f"{self.model}: it misses {name} most, by {rmse:.3g} {unit} (rms); the logs' own does not move"

    @property
    def errors(self) -> dict[str, dict[str, Any]]:
        """Log -> output -> rmse, unit, nrmse_percent, largest."""
        return _errors(self.recordings, self.residuals)

    def to_dict(self) -> dict[str, Any]:
        return {"logs": {log: {"simulation": e} for log, e in self.errors.items()}, "notes": list(self.notes)}

    def to_frame(self) -> "pd.DataFrame":
        """A row per log and output."""
        import pandas as pd

        rows = {(log, name): e for log, outputs in self.errors.items() for name, e in outputs.items()}
        return pd.DataFrame.from_dict(rows, orient="index").rename_axis(["log", "output"])

    def summary(self) -> Text:
        return Text("\n".join([wrapped(self.headline()), _table_of(self.recordings, self.residuals)]))


@dataclass(frozen=True, repr=False)
class FmuDiagnosed(Result):
    """What the output residuals of an FMU show."""

    model: str
    outputs: "tuple[Shown, ...]"
    fit: "OutputError | None"
    notes: tuple[str, ...]

    @property
    def verdict(self) -> str:
        """depends (a finding is named), unexplained (structure, but none) or nothing_detectable (noise)."""
        if any(o.findings for o in self.outputs):
            return "depends"
        return (
            "unexplained" if any(_structured(o, self.outputs) for o in self.outputs) else "nothing_detectable"
        )

    def headline(self) -> str:
        if self.verdict == "nothing_detectable":
            return f"{self.model}: what it leaves of its outputs is white noise"
        if self.verdict == "depends":
            return f"{self.model}: " + "; ".join(_sentence(f, o) for o in self.outputs for f in o.findings)
        names = ", ".join(o.output for o in self.outputs if _structured(o, self.outputs))
        return f"{self.model}: the residual of {names} is no white noise, and follows no signal that is known"

    def to_dict(self) -> dict[str, Any]:
        outputs = {
            o.output: {
                "rms": o.rms,
                "unit": o.unit,
                "white_p_value": o.white_p,
                "findings": [f.__dict__ | {"of": list(f.of)} for f in o.findings],
            }
            for o in self.outputs
        }
        values = self.fit.values if self.fit else {}
        return {"verdict": self.verdict, "outputs": outputs, "fitted": values, "notes": list(self.notes)}

    def to_frame(self) -> "pd.DataFrame":
        """A row per finding."""
        import pandas as pd

        heads = ["output", "kind", "of", "at", "size", "share_percent", "p_value"]
        rows = [[f.output, f.kind, ", ".join(f.of), f.at, f.size, f.share_percent, f.p_value]
                for o in self.outputs for f in o.findings]  # fmt: skip
        return pd.DataFrame(rows, columns=heads)

    def summary(self) -> Text:
        lines = [wrapped(_sentence(f, o) + ".", "  ") for o in self.outputs for f in o.findings]
        return Text("\n".join(lines or [wrapped(self.headline())]))


def _sentence(finding: "Finding", output: "Shown") -> str:
    share = f"{finding.share_percent:.0f} % of what is left of {finding.output}"
    names = " or ".join(finding.of)
    if finding.kind == "constant":
        return f"{share} is a constant of {finding.at:.3g} {output.unit}".rstrip()
    if finding.kind == "delay":
        late = "later" if finding.at > 0 else "earlier"
        return f"{share}: the log is {abs(finding.at):.3g} s {late} than the model"
    if finding.kind == "order":
        turn = f"{finding.at:g} times per turn"
        return f"{share} is periodic in {names}, {turn}, rms {finding.size:.3g} {output.unit}"
    return f"{share} depends on {names}, rms {finding.size:.3g} {output.unit}"


def _structured(output: "Shown", outputs: "tuple[Shown, ...]") -> bool:
    return output.white_p * len(outputs) < GREYBOX.white


def _errors(
    recordings: "tuple[Recording, ...]", residuals: tuple[np.ndarray, ...]
) -> dict[str, dict[str, Any]]:
    out = {}
    for r, left in zip(recordings, residuals, strict=True):
        rmse = np.sqrt(np.mean(left**2, axis=0))
        signal = r.measured.std(axis=0)
        percent = np.divide(100 * rmse, signal, out=np.full(len(rmse), np.nan), where=signal > 0)
        out[r.source] = {
            name: {
                "rmse": float(rmse[i]),
                "unit": r.units[i],
                "nrmse_percent": finite(percent[i]),
                "largest": float(np.abs(left[:, i]).max()),
            }
            for i, name in enumerate(r.outputs)
        }
    return out


def _percent(value: float | None) -> str:
    return "-" if value is None else f"{value:.3g}"


def _table_of(recordings: "tuple[Recording, ...]", residuals: tuple[np.ndarray, ...]) -> str:
    heads = ("log", "output", "rmse", "% of signal", "largest", "unit")
    rows = [
        (log, name, f"{e['rmse']:.3g}", _percent(e["nrmse_percent"]), f"{e['largest']:.3g}", e["unit"])
        for log, outputs in _errors(recordings, residuals).items()
        for name, e in outputs.items()
    ]
    return table(heads, rows, numbers=(2, 3, 4))
