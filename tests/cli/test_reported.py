"""How a command ends that something interrupts or that meets a fault."""

import click
import pytest
from click.testing import CliRunner

from pyident.cli.common.shared import reported


def ended(body):
    return CliRunner().invoke(click.command()(reported(body)))


def test_a_fault_while_making_way_for_ctrl_c_is_the_ctrl_c():
    def command():
        try:
            raise KeyboardInterrupt
        finally:
            raise AssertionError

    result = ended(command)
    assert (result.exit_code, result.stderr) == (130, "stopped\n")


@pytest.mark.parametrize("earlier", [None, ValueError("first")])
def test_a_fault_of_ours_says_so(earlier):
    def command():
        raise AssertionError("second") from earlier

    result = ended(command)
    assert result.exit_code == 70
    assert result.stderr.startswith("fault in pyident itself: AssertionError: second")
    assert result.stderr.count("\n") == 1
