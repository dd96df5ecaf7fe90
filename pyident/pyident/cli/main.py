"""The command line: a command is a line here and a file beside, which calls the front door."""

import click

from pyident.cli.common.lazy import Entry, lazy_group

COMMANDS = {
    "add": Entry("pyident.cli.judge", "add_command", "Add EFFECT to MODEL and judge it on held-out data."),
    "compare": Entry("pyident.cli.judge", "compare_command", "Show where an identified MODEL fails on logs."),
    "data": Entry("pyident.cli.data", "data", "Public measurements of real robots."),
    "diagnose": Entry("pyident.cli.judge", "diagnose_command", "Say which physical effect MODEL lacks."),
    "effects": Entry(
        "pyident.cli.effects", "effects", "List the laws that a robot file may name, or show one."
    ),
    "explain": Entry(
        "pyident.cli.explain", "explain_command", "Rank the laws by what each would explain of one stretch."
    ),
    "excite": Entry(
        "pyident.cli.excite", "excite_command", "Design the motion that tells the most about MODEL."
    ),
    "export": Entry("pyident.cli.simulate", "export", "Write MODEL as an FMU."),
    "identify": Entry(
        "pyident.cli.identify", "identify_command", "Identify the dynamic parameters of MODEL from logs."
    ),
    "log": Entry("pyident.cli.data", "log", "Read recordings of other tools."),
    "open": Entry("pyident.cli.open", "open_command", "Open the workbench on FOLDER."),
    "payload": Entry(
        "pyident.cli.payload", "payload_command", "Find the ten inertial parameters of what MODEL carries."
    ),
    "plan": Entry(
        "pyident.cli.excite", "plan", "Check a planned motion, or write it for another controller."
    ),
    "robots": Entry(
        "pyident.cli.robots", "robots", "List the robots that ship, or copy one; import and export others."
    ),
    "simulate": Entry("pyident.cli.simulate", "simulate", "Simulate MODEL as an FMU and write the log."),
    "study": Entry("pyident.cli.study", "study", "Run studies and print one table."),
    "sweep": Entry(
        "pyident.cli.study", "sweep", "Simulate the parameter sets that PLAN, a TOML file, describes."
    ),
    "trust": Entry(
        "pyident.cli.trust",
        "trust_command",
        "Let Python files of effects or metrics run.",
    ),
}


@click.group(cls=lazy_group(COMMANDS), context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="flexident")
def main() -> None:
    """Model robots with flexible joints, simulate them as FMUs, identify and diagnose them.

    MODEL is a shipped robot's name (see `pyident robots`) or a TOML file.
    """
