"""The command `pyident`. Processes that it starts import this file once more: let it import nothing more."""

import sys

TYPE_CHECKING = False
if TYPE_CHECKING:
    from types import FrameType


def main() -> None:
    """Run the command; Ctrl-C at any time ends in one line, a request to terminate closes what is open."""
    import atexit
    import os
    import signal

    os.environ.setdefault("PYTHONSAFEPATH", "1")  # no process of ours runs a module that lies beside a log
    signal.signal(signal.SIGTERM, _asked)
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _asked)
    sys.unraisablehook = _once_more
    interrupted: list[int] = []
    atexit.register(_leave, interrupted)  # the first that is registered is the last that is called
    try:
        _command()
    except SystemExit as end:
        if end.code == 128 + signal.SIGINT:
            interrupted.append(128 + signal.SIGINT)
        raise


def _command() -> None:
    import signal

    try:
        from pyident.cli.main import main

        main()
    except KeyboardInterrupt:
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        print("stopped", file=sys.stderr)
        raise SystemExit(128 + signal.SIGINT) from None


def _asked(number: int, frame: "FrameType | None") -> None:
    """End at a Ctrl-C or a request to terminate, as soon as what is raised will be heard."""
    import signal

    if frame and _deaf(frame):
        _ask_again(number)
        return
    if number == signal.SIGINT:
        raise KeyboardInterrupt
    raise SystemExit(128 + number)


def _deaf(frame: "FrameType") -> bool:
    """Whether what is raised in this frame may be forgotten.

    Some packages take whatever is raised while they import another for the lack of it. CasADi forgets what
    its C code meets in Python, which it asks for conversions, and has `except:` in functions of its own.
    """
    if frame.f_globals.get("__name__") == "casadi.casadi" and "_casadi" not in frame.f_code.co_names:
        return True
    caller = frame.f_back
    while caller:
        if caller.f_code.co_name == "_find_and_load" or "_casadi" in caller.f_code.co_names:
            return True
        caller = caller.f_back
    return False


def _once_more(lost: "sys.UnraisableHookArgs") -> None:
    """Ask again for a Ctrl-C, or a request to terminate, that Python lost.

    What is raised in a destructor, or in a callback of an import or of C, is only reported there.
    """
    import signal

    asked = {KeyboardInterrupt: signal.SIGINT, SystemExit: signal.SIGTERM}.get(lost.exc_type)
    if asked is None:
        sys.__unraisablehook__(lost)
    else:
        _ask_again(asked)


def _ask_again(number: int) -> None:
    import os
    import threading

    again = threading.Timer(0.01, os.kill, (os.getpid(), number))
    again.daemon = True
    again.start()


def _leave(codes: list[int]) -> None:
    """End with the exit code after a Ctrl-C, if there is one.

    When it met a string under execution (the making of a dataclass), Python would end by the signal instead.
    """
    import os

    if codes:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(codes[-1])


if __name__ == "__main__":
    main()
