"""What a click asks for, as the command that asks the same."""

from pathlib import Path

from pyident.workbench.project import command
from pyident.workbench.work import Inputs

Span = tuple[float, float] | None


def checking(inputs: Inputs) -> str:
    """A comparison reads and checks logs before anything else."""
    return command("compare", _model(inputs), _every_log(inputs), _mapping(inputs))


def judging(inputs: Inputs) -> str:
    """Where it counts which logs are fitted and which are held out."""
    return command("diagnose", _model(inputs), inputs.log_names(), inputs.options())


def comparing(inputs: Inputs, file: str) -> str:
    """A model with all logs; file: of the results."""
    return command("compare", _model(inputs), _every_log(inputs), _mapping(inputs), "--json", file)


def inspecting(inputs: Inputs, log: str, mapping: str = "") -> str:
    """What a file holds; mapping: the file to write the proposal to."""
    robot = ["--robot", _model(inputs)] if inputs.model else []
    return command("log", "inspect", log, robot, ["-o", mapping] if mapping else [])


def explaining(inputs: Inputs, log: str, coordinate: str, span: Span, band: Span = None) -> str:
    """Which law would take a stretch of an equation."""
    words = ["--log", Path(log).name, "--equation", coordinate]
    if span:
        words += ["--span", *(f"{t:.6g}" for t in span)]
    if band:
        words += ["--band", *(f"{f:.6g}" for f in band)]
    return command("explain", _model(inputs), inputs.log_names(), words, inputs.options())


def exporting(inputs: Inputs, output: str, fmi: int) -> str:
    """The model in the format that the file's ending names."""
    if Path(output).suffix in (".urdf", ".xml"):
        return command("robots", "export", _model(inputs), "-o", output)
    version = ["--fmi", str(fmi)] if Path(output).suffix == ".fmu" else []
    return command("export", _model(inputs), "-o", output, version)


def packing(inputs: Inputs, stem: str) -> str:
    """The model in every format, a command each."""
    files = ((f"{stem}.urdf", 2), (f"{stem}.xml", 2), (f"{stem}.fmu", 2), (f"{stem}_fmi3.fmu", 3))
    return " && ".join(exporting(inputs, name, fmi) for name, fmi in (*files, (f"{stem}.ssp", 2)))


def reporting(inputs: Inputs, what: str, output: str) -> str:
    """The page of a comparison or a diagnosis."""
    return f"{checking(inputs) if what == 'compare' else judging(inputs)} -o {output}"


def _model(inputs: Inputs) -> str:
    return Path(inputs.model).name


def _every_log(inputs: Inputs) -> list[str]:
    return [*inputs.log_names(), *(Path(log).name for log in inputs.heldout)]


def _mapping(inputs: Inputs) -> list[str]:
    return ["--mapping", Path(inputs.mapping).name] if inputs.mapping else []
