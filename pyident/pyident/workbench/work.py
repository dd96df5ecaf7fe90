"""What jobs do: calls of the front door with files as arguments, results as files beside them."""

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from pyident.extension.waterfall import Step

if TYPE_CHECKING:
    from pyident.diagnosis.result import Diagnosis

Progress = Callable[[float], None]
REFUSED = "refused: "  # how the sentence of a log that must not be used begins


@dataclass(frozen=True)
class Outcome:
    """What came of a law that was added.

    reason      why it is refused; empty: it is accepted
    waterfall   errors before and after
    gains       relative fall of the mean square error on held-out data: equations, simulation
    """

    reason: str
    waterfall: tuple[Step, ...]
    gains: tuple[float, float]

    @property
    def accepted(self) -> bool:
        return not self.reason


@dataclass(frozen=True)
class Fitted:
    """An identification in words: what the logs determine, and the values."""

    determined: str
    summary: str


@dataclass(frozen=True)
class Inputs:
    """What a question is asked of. model: shipped name or path; logs, heldout, mapping: paths."""

    model: str
    logs: tuple[str, ...]
    heldout: tuple[str, ...] = ()
    mapping: str = ""

    def options(self) -> list[str]:
        """As words of a command line."""
        held = [word for log in self.heldout for word in ("--holdout", Path(log).name)]
        return held + (["--mapping", Path(self.mapping).name] if self.mapping else [])

    def arguments(self) -> dict[str, Any]:
        """As every verb takes them that fits some logs and judges on others."""
        return {"logs": list(self.logs), "heldout": list(self.heldout), "mapping": self.mapping or None}

    def log_names(self) -> list[str]:
        return [Path(log).name for log in self.logs]


def compared(inputs: Inputs, json_file: str, progress: Progress) -> Any:
    """The comparison of the model with every log, written to `json_file`, too."""
    import pyident as pi

    logs = [*inputs.logs, *inputs.heldout]
    compared = pi.compare(inputs.model, logs, mapping=inputs.mapping or None, progress=progress)
    _write(json_file, compared.to_dict())
    return compared


def asked(inputs: Inputs, compared: Any, progress: Progress) -> Any:
    """What every law would take of the residual along every log; those held out fit nothing."""
    from pyident.verbs.explain import waves_of

    return waves_of(compared, inputs.model, **inputs.arguments(), progress=progress)


def diagnosed(inputs: Inputs, json_file: str, progress: Progress) -> "Diagnosis":
    """The diagnosis, written to `json_file`, too."""
    import pyident as pi

    diagnosed = pi.diagnose(inputs.model, **inputs.arguments(), progress=progress)
    _write(json_file, diagnosed.to_dict())
    return diagnosed.diagnosis


def added(
    inputs: Inputs, effect: str, joint: int, output: str, json_file: str, progress: Progress
) -> Outcome:
    """The model with one more law, written to `output` if it is accepted."""
    import pyident as pi

    added = pi.add_effect(inputs.model, effect, joint, **inputs.arguments(), progress=progress)
    _write(json_file, added.to_dict())
    if added.accepted:
        added.save(output)
    found = added.extended
    return Outcome(found.reason, found.waterfall, found.gains)


def identified(inputs: Inputs, output: str, json_file: str, progress: Progress) -> Fitted:
    """The model with parameters from the logs, judged on those held out, written to `output`."""
    import pyident as pi

    fit = pi.identify(inputs.model, **inputs.arguments(), progress=progress)
    fit.save(output)
    _write(json_file, fit.to_dict())
    return Fitted(fit.determined(), str(fit.summary()))


def exported(model: str, output: str, fmi: Literal[2, 3], progress: Progress) -> str:
    """The model as URDF, MJCF (.xml), FMU or SSP, by the ending of `output`."""
    if Path(output).suffix in (".urdf", ".xml"):
        from pyident.verbs.robots import export_robot

        export_robot(model, output)
    else:
        import pyident as pi

        pi.export_fmu(model, output, fmi=fmi)
    progress(1.0)
    return output


def reported(result: Any, output: str, progress: Progress) -> str:
    """The page of a comparison or a diagnosis."""
    from pyident.verbs.judged import Compared, Diagnosed

    page = result if isinstance(result, Compared) else Diagnosed(result, ())
    page.save(output)
    progress(1.0)
    return output


def proposed(log: str, model: str, progress: Progress) -> tuple[str, list[dict[str, Any]], list[str], str]:
    """What a file's columns seem to be: its name, a row each, open questions, the mapping's text."""
    from pyident.verbs.recordings import proposed_mapping

    proposal = proposed_mapping([log], model or None)
    rows = [
        {
            "column": c.column,
            "signal": c.name or c.signal,
            "unit": c.unit or "",
            "sure": "yes" if c.sure else "?",
        }
        for c in proposal.channels
    ]
    progress(1.0)
    return Path(log).name, rows, list(proposal.questions), proposal.toml()


def planned(
    inputs: Inputs, separate: tuple[str, ...], reveal: str, output: str, json_file: str, progress: Progress
) -> tuple[str, str]:
    """A motion that tells two laws apart or shows one, written to `output`; its name and what it promises."""
    import pyident as pi

    plan = pi.excite(inputs.model, separate=separate, reveal=reveal or None, progress=progress)
    plan.save(output)
    _write(json_file, plan.to_dict())
    return Path(output).name, plan.headline()


def bundled(model: str, output: str, script: str, progress: Progress) -> str:
    """The model in every format, and the script of what was done."""
    from pyident.verbs.robots import bundle

    return str(bundle(model, output, script, progress))


def imported(
    file: str, output: str, flexible: tuple[int, ...], twist: tuple[int, ...], progress: Progress
) -> tuple[str, ...]:
    """A URDF or MJCF as a robot file; sentences on what it does not hold."""
    from pyident.verbs.robots import import_robot

    notes = import_robot(file, output, flexible=flexible, twist=twist)
    progress(1.0)
    return notes


def checked(inputs: Inputs, names: Sequence[str], progress: Progress) -> dict[str, list[str]]:
    """Log -> sentences of the checks; one that cannot be used has its error as the only sentence."""
    import pyident as pi

    sentences: dict[str, list[str]] = {}
    for i, name in enumerate(names):
        try:
            log = pi.read_log(name, robot=inputs.model or None, mapping=inputs.mapping or None)
            defects = pi.check_log(pi.load_robot(inputs.model), log)
            listed = [f"{len(log)} samples at {1 / log.period:.4g} Hz", *log.notes]
            refused = [f"{REFUSED}{d.sentence}" for d in defects if d.severity == "gross"]
            doubted = [f"to look at: {d.sentence}" for d in defects if d.severity != "gross"]
            sentences[Path(name).name] = [*refused, *listed, *doubted]
        except ValueError as error:
            sentences[Path(name).name] = [f"{REFUSED}{error}"]
        progress((i + 1) / len(names))
    return sentences


def _write(path: str, content: Any) -> None:
    from flexmodels.atomic import replacing

    Path(path).parent.mkdir(parents=True, exist_ok=True)
    with replacing(path) as file:
        file.write_text(json.dumps(content, indent=2) + "\n", encoding="utf-8")
