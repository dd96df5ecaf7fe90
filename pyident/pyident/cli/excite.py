"""`pyident excite` and `pyident plan`: the next experiment."""

import sys

import click

import pyident as pi
from pyident.cli.common.outputs import LOG, TRAJECTORY
from pyident.cli.common.shared import (
    assignments,
    effects_option,
    json_option,
    output_option,
    progress_bar,
    reported,
    show,
    show_notes,
    write_json,
)

limit_option = assignments(
    "--limit", "limits", "joint2.speed=1.5", "A limit in addition to the robot file's, in SI units"
)
home_option = assignments("--home", "home", "joint2=-1.57", "Where a joint sets out, instead of 0 [rad or m]")
noise_option = assignments("--noise", "noise", "joint1.e=2e-6", "Standard deviation of a sensor's noise")
radius_option = click.option(
    "--radius", type=float, help="Radius [m] of the capsules that stand for the links."
)
floor_option = click.option(
    "--floor", type=float, default=0.0, show_default=True, help="Height of the floor above the base [m]."
)
spread_option = click.option(
    "--spread",
    type=float,
    default=0.25,
    show_default=True,
    help="Fraction by which parameters may be off; robots that far off rehearse the motion.",
)
no_floor_option = click.option("--no-floor", is_flag=True, help="There is no floor below the robot.")


@click.command(name="excite")
@click.argument("model")
@output_option(LOG)
@click.option("--duration", type=float, default=10.0, show_default=True, help="Duration of the motion [s].")
@click.option("--rate", type=float, help="Samples per second, if no controller sets them.")
@click.option("--separate", nargs=2, metavar="EFFECT@JOINT EFFECT@JOINT", help="Tell two effects apart.")
@click.option("--reveal", metavar="EFFECT@JOINT[=SIZE]", help="Make an effect visible.")
@click.option(
    "--criterion",
    type=click.Choice(["information", "condition"]),
    default="information",
    show_default=True,
    help="What an identification should have: information beside the noise, or a small condition number.",
)
@limit_option
@home_option
@noise_option
@radius_option
@floor_option
@no_floor_option
@spread_option
@click.option("--seconds", type=float, default=120.0, show_default=True, help="Time limit of the search [s].")
@click.option(
    "--evaluations",
    type=click.IntRange(20),
    default=1500,
    show_default=True,
    help="Most evaluations of the search.",
)
@click.option("--seed", type=int, default=0, show_default=True, help="Seed of the search.")
@effects_option
@json_option
@reported
def excite_command(
    model: str,
    output: str,
    duration: float,
    rate: float | None,
    separate: tuple[str, str] | None,
    reveal: str | None,
    criterion: str,
    limits: dict[str, float],
    home: dict[str, float],
    noise: dict[str, float],
    radius: float | None,
    floor: float,
    no_floor: bool,
    spread: float,
    seconds: float,
    evaluations: int,
    seed: int,
    json_file: str | None,
) -> None:
    """Design the motion that tells the most about MODEL within its limits; Ctrl-C keeps the best so far.

    The file is an experiment for pyident simulate and for pyident plan.

    \b
    Example: pyident excite four_link -o plan.parquet
             pyident excite four_link --separate stribeck@2 presliding@2 -o p.csv
    """
    with progress_bar("designing a motion (Ctrl-C: take the best so far)") as progress:
        found = pi.excite(
            model,
            separate=separate or (),
            reveal=reveal,
            criterion=criterion,
            duration=duration,
            rate=rate,
            limits=limits,
            home=home,
            noise=noise,
            radius=radius,
            floor=None if no_floor else floor,
            spread=spread,
            seconds=seconds,
            evaluations=evaluations,
            seed=seed,
            progress=progress,
        )
    show_notes(found.notes)
    show(found.summary())
    found.save(output)
    show(f"wrote {output}")
    write_json(json_file, found.to_dict())


@click.group(name="plan")
def plan() -> None:
    """Check a planned motion, or write it for another controller.

    Example: pyident plan check plan.parquet four_link
    """


@plan.command(name="check")
@click.argument("plan_file", metavar="PLAN")
@click.argument("model")
@limit_option
@noise_option
@radius_option
@floor_option
@no_floor_option
@spread_option
@click.option(
    "--runs",
    type=click.IntRange(0, 100_000),
    default=24,
    show_default=True,
    help="Robots with other parameters that run it, too.",
)
@effects_option
@json_option
@reported
def check_command(
    plan_file: str,
    model: str,
    limits: dict[str, float],
    noise: dict[str, float],
    radius: float | None,
    floor: float,
    no_floor: bool,
    spread: float,
    runs: int,
    json_file: str | None,
) -> None:
    """Check PLAN against the limits and torques of MODEL, its own links and the floor.

    The exit code is 1 if the robot must not run it.

    Example: pyident plan check plan.parquet four_link --limit joint2.torque=400
    """
    with progress_bar("rehearsing") as progress:
        found = pi.check_plan(
            plan_file,
            model,
            limits=limits,
            noise=noise,
            radius=radius,
            floor=None if no_floor else floor,
            spread=spread,
            others=runs,
            progress=progress,
        )
    show_notes(found.notes)
    show(found.summary())
    write_json(json_file, found.to_dict())
    if not found.safe:
        sys.exit(1)


@plan.command(name="export")
@click.argument("plan_file", metavar="PLAN")
@click.argument("model")
@output_option(TRAJECTORY)
@click.option("--rate", type=float, help="Points per second.  [default: the plan's]")
@click.option("--degrees", is_flag=True, help="Degrees and mm in a table, instead of rad and m.")
@effects_option
@reported
def export_command(plan_file: str, model: str, output: str, rate: float | None, degrees: bool) -> None:
    """Write PLAN as a table (.csv) or a ROS JointTrajectory (.json, .yaml).

    Example: pyident plan export plan.parquet four_link -o trajectory.yaml --rate 50
    """
    path = pi.export_plan(plan_file, model, output, rate=rate, degrees=degrees)
    show(f"wrote {path}")
