"""`pyident simulate` and `pyident export`: robots as FMUs."""

from pathlib import Path
from typing import Literal

import click

import pyident as pi
from pyident.cli.common.outputs import FMU, LOG
from pyident.cli.common.shared import (
    console,
    effects_option,
    json_option,
    mapping_option,
    output_option,
    progress_bar,
    reported,
    set_option,
    show,
    write_json,
)


@click.command()
@click.argument("model")
@output_option(FMU)
@effects_option
@click.option("--fmi", type=click.Choice(["2", "3"]), default="2", show_default=True, help="Version of FMI.")
@click.option(
    "--part",
    type=click.Choice(["arm", "plant"]),
    default="arm",
    show_default=True,
    help="The arm with its controller, or the plant alone: its inputs are the motor torques.",
)
@click.option(
    "--platforms",
    type=click.Choice(["host", "all"]),
    default="host",
    show_default=True,
    help="This machine's binary, or Linux, Windows and macOS in one file.",
)
@set_option
@json_option
@reported
def export(
    model: str,
    output: str,
    fmi: str,
    part: Literal["arm", "plant"],
    platforms: Literal["host", "all"],
    parameters: dict[str, float],
    json_file: str | None,
) -> None:
    """Write MODEL as an FMU for model exchange and co-simulation.

    A file that ends in .ssp holds plant and controller as two FMUs (FMI 2.0) and their connections, one that
    ends in .mo the arm as Modelica text.

    Example: pyident export four_link -o arm.fmu --fmi 3, or pyident export emps -o emps.fmu --part plant
    """
    robot = pi.load_robot(model)
    with console.status("generating and compiling"):
        path = pi.export_fmu(
            robot, output, 2 if fmi == "2" else 3, part=part, platforms=platforms, parameters=parameters
        )
    show(f"wrote {path}")
    kind = {".ssp": "ssp", ".mo": "modelica"}.get(Path(output).suffix, "fmu")
    write_json(json_file, {kind: str(path), "parameters": robot.parameters | parameters})


@click.command()
@click.argument("model")
@click.option(
    "--experiment", required=True, help="identification, line, or a file with time and joint{k}.r columns."
)
@mapping_option
@output_option(LOG, default="simulation.parquet")
@effects_option
@set_option
@click.option(
    "--time-limit",
    type=float,
    default=60.0,
    show_default=True,
    help="Longest silence of an FMU before it is stopped [s].",
)
@click.option(
    "--window",
    type=int,
    default=20,
    show_default=True,
    help="Samples from which a free run takes its initial state.",
)
@json_option
@reported
def simulate(
    model: str,
    experiment: str,
    mapping: str | None,
    output: str,
    parameters: dict[str, float],
    time_limit: float,
    window: int,
    json_file: str | None,
) -> None:
    """Simulate MODEL as an FMU and write the log (CSV, Parquet or MAT by its ending).

    MODEL may also be an FMU, of any tool, with inputs joint{k}.r and outputs joint{k}.e and so on; the
    experiment is then a file. A recorded log is replayed under its own commands. A robot without a
    controller runs freely under a log's torques, from the state that its first samples show.

    Example: pyident simulate four_link --experiment identification -o log.parquet
    """
    with progress_bar(f"simulating {model}") as progress:
        log = pi.simulate(
            model,
            experiment,
            parameters=parameters,
            mapping=mapping,
            time_limit=time_limit,
            window=window,
            progress=progress,
        )
    pi.write_log(log, output)
    duration = log.period * (len(log) - 1)
    for note in log.notes:
        show(note)
    show(f"wrote {output}: {len(log)} samples, {duration:g} s")
    write_json(json_file, {"log": output, "samples": len(log), "duration_s": duration})
