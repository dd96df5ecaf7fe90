"""What the fit and the residual of a foreign FMU would say if its thresholds were half or twice as large.

All outputs are drawn here, with what is hidden in them known; no FMU is needed.
"""

from collections.abc import Callable, Iterator
from dataclasses import asdict
from pathlib import Path

import numpy as np

from pyident.greybox.output_error import output_error
from pyident.greybox.recording import Recording
from pyident.greybox.residual import shown
from pyident.greybox.search import Free
from pyident.rules.greybox import GREYBOX
from pyident.rules.rule import RulesError
from pyident.sweep.studies import StudyResult, row

from ..half_and_twice.answers import reported
from ..half_and_twice.variants import Variant, in_force, variants

GROUPS = {"greybox": GREYBOX}
LOOKED_AT = ("smooth", "starts", "folds", "material", "tie", "level")
DRAWS = 20
_TIME = 0.004 * np.arange(2500)


def run(folder: Path, progress: Callable[[float], None], draws: int = DRAWS) -> StudyResult:
    """A line per threshold; draws: of each kind of output."""
    folder.mkdir(parents=True, exist_ok=True)
    tried = [v for v in variants(GROUPS) if not v.name or v.name in LOOKED_AT]
    said = {}
    for number, variant in enumerate(tried, start=1):
        try:
            with in_force(variant, GROUPS):
                said[variant] = counted(draws)
        except RulesError:
            said[variant] = None
        progress(number / len(tried))
    as_they_are = row(f"as they are, {draws} of each kind", _sentence(said[Variant()] or {}))
    return reported(folder / "greybox_thresholds.csv", as_they_are, _lines(said))


def counted(draws: int) -> dict[str, int]:
    """How often each thing happened."""
    total: dict[str, int] = {}
    for seed in range(draws):
        for count in (_dependences(seed), _fits(seed)):
            for name, value in count.items():
                total[name] = total.get(name, 0) + value
    return total


def _dependences(seed: int) -> dict[str, int]:
    """Coloured noise alone; then friction in white noise, with a look-alike of speed among the signals."""
    rng = np.random.default_rng([seed, 1])
    frequency, phase = rng.uniform(0.2, 1.5, 5), rng.uniform(0, 6, 5)
    waves = 2 * np.pi * np.outer(_TIME, frequency) + phase
    angle, speed = np.sin(waves).sum(axis=1), (np.cos(waves) * 2 * np.pi * frequency).sum(axis=1)
    alike = speed + 0.3 * np.std(speed) * rng.standard_normal(len(_TIME))
    white, noise = rng.standard_normal(len(_TIME)), np.zeros(len(_TIME))
    for i in range(1, len(_TIME)):
        noise[i] = 0.8 * noise[i - 1] + 0.6 * white[i]
    signals = {name: [x] for name, x in (("angle", angle), ("speed", speed), ("alike", alike))}

    def names(residual: np.ndarray) -> tuple[str, ...]:
        found = shown(
            "y", "N m", [_TIME], [residual], [angle], signals, {"angle": signals["angle"]}, 1
        ).findings
        return found[0].of if found else ()

    named = names(white + 0.3 * np.sign(speed))
    return {
        "noise explained": bool(names(noise)),
        "friction named": "speed" in named,
        "friction named alone": named == ("speed",),
    }


def _fits(seed: int) -> dict[str, int]:
    """A sine of unknown frequency, started far off, and a stair, whose slopes are none."""
    rng = np.random.default_rng([seed, 2])
    time = 0.01 * np.arange(500)
    true = float(rng.uniform(3.0, 12.0))

    def sine(recording, sets, names, progress=None):
        return np.array([np.sin(v["omega"] * time)[:, None] for v in sets])

    def stair(recording, sets, names, progress=None):
        return np.array([(np.round(20 * v["gain"] * time) / 20)[:, None] for v in sets])

    def fit(model, free: Free):
        measured = model(None, [{"omega": true, "gain": true}], ())[0] + 0.02 * rng.standard_normal((500, 1))
        log = Recording("a log", time, {}, ("y",), ("rad",), measured)
        return output_error([log], model, [free])

    far = fit(sine, Free("omega", "rad/s", 7.0, 2.0, 14.0)).values["omega"]
    steps = fit(stair, Free("gain", "1", 0.9 * true)).estimates[0].std
    return {
        "frequency found": abs(far - true) < 0.05,
        "stair without interval": bool(np.isnan(steps)),
    }


def _sentence(found: dict[str, int]) -> str:
    return ", ".join(f"{name} {count}" for name, count in found.items())


def _lines(said: dict[Variant, dict[str, int] | None]) -> Iterator[dict[str, str]]:
    usual = said[Variant()] or {}
    for name in LOOKED_AT:
        words = {}
        for factor in ("half", "twice"):
            found = said[Variant("greybox", name, factor)]
            changed = {n: v for n, v in (found or {}).items() if v != usual[n]}
            words[factor] = "refused" if found is None else _sentence(changed) or "the same"
        yield {"threshold": f"greybox.{name} = {asdict(GREYBOX)[name]}", **words}
