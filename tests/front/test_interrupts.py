"""How the command ends: a Ctrl-C is one line and code 130, wherever it meets the program."""

import atexit
import os
import signal
import sys
import threading
from types import SimpleNamespace

import pytest

import pyident.__main__ as command
from pyident.cli import main as commands

DEAF = """
def converted():  # as CasADi's own functions, which forget what their C code meets
    return sys._getframe()

def asks_c():
    return sys._getframe() if _casadi else None
"""


@pytest.fixture
def handlers():
    """The signals' handlers and the hook, put back."""
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM, signal.SIGUSR1)}
    hook = sys.unraisablehook
    yield
    sys.unraisablehook = hook
    for number, handler in before.items():
        signal.signal(number, handler)


def _frame(name: str, of: str):
    """The frame of a function of a module of this name."""
    module = {"__name__": of, "sys": sys, "_casadi": True}
    exec(DEAF, module)
    return module[name]()


def test_a_request_is_raised_where_it_is_heard():
    here = sys._getframe()
    with pytest.raises(KeyboardInterrupt):
        command._asked(signal.SIGINT, here)
    with pytest.raises(SystemExit) as end:
        command._asked(signal.SIGTERM, None)
    assert end.value.code == 128 + signal.SIGTERM


def test_a_request_that_would_be_forgotten_is_made_again(monkeypatch):
    again = []
    monkeypatch.setattr(command, "_ask_again", again.append)
    deaf = _frame("converted", "casadi.casadi")
    command._asked(signal.SIGINT, deaf)
    assert again == [signal.SIGINT]
    assert not command._deaf(_frame("converted", "numpy"))
    assert not command._deaf(_frame("asks_c", "casadi.casadi"))  # calls C itself: what it raises arrives

    def _find_and_load():  # named as what Python calls for every import
        return _inner()

    def _inner():
        return command._deaf(sys._getframe())

    assert _find_and_load()


def test_what_python_lost_is_asked_for_again(monkeypatch):
    again, reported = [], []
    monkeypatch.setattr(command, "_ask_again", again.append)
    monkeypatch.setattr(sys, "__unraisablehook__", reported.append)
    for kind in (KeyboardInterrupt, SystemExit, ValueError):
        command._once_more(SimpleNamespace(exc_type=kind))  # pyright: ignore[reportArgumentType]
    assert again == [signal.SIGINT, signal.SIGTERM]
    assert [lost.exc_type for lost in reported] == [ValueError]


def test_a_signal_comes_again_a_moment_later(handlers):
    came = threading.Event()
    signal.signal(signal.SIGUSR1, lambda *_: came.set())
    command._ask_again(signal.SIGUSR1)
    assert not came.is_set()
    assert came.wait(5)


def test_ctrl_c_ends_in_one_line(handlers, monkeypatch, capsys):
    def interrupted():
        raise KeyboardInterrupt

    monkeypatch.setattr(commands, "main", interrupted)
    with pytest.raises(SystemExit) as end:
        command._command()
    assert end.value.code == 130
    assert capsys.readouterr().err == "stopped\n"
    assert signal.getsignal(signal.SIGINT) is signal.SIG_IGN  # a second one changes nothing any more


@pytest.mark.parametrize(("code", "kept"), [(130, [130]), (2, []), (0, [])])
def test_the_code_after_a_ctrl_c_is_the_last_word(handlers, monkeypatch, code, kept):
    """Python would end by the signal, had it met a string under execution."""

    def ends():
        raise SystemExit(code)

    last, exits = [], []
    monkeypatch.setattr(atexit, "register", lambda function, *given: last.append((function, given)))
    monkeypatch.setattr(os, "_exit", exits.append)
    monkeypatch.setattr(command, "_command", ends)
    monkeypatch.setenv("PYTHONSAFEPATH", "0")
    signal.signal(signal.SIGINT, signal.default_int_handler)
    with pytest.raises(SystemExit) as end:
        command.main()
    assert end.value.code == code
    assert os.environ["PYTHONSAFEPATH"] == "0"  # what the user set stays
    assert signal.getsignal(signal.SIGINT) is command._asked
    ((leave, given),) = last
    leave(*given)
    assert exits == kept
