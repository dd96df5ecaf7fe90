"""The command `pyident`. Processes that it starts import this file once more: let it import nothing more."""

import sys


def main() -> None:
    """Run the command; Ctrl-C at any time ends in one line, a request to terminate closes what is open."""
    import os
    import signal

    def terminate(*_: object) -> None:
        raise SystemExit(128 + signal.SIGTERM)

    os.environ.setdefault("PYTHONSAFEPATH", "1")  # no process of ours runs a module that lies beside a log
    signal.signal(signal.SIGTERM, terminate)
    sys.unraisablehook = _once_more
    try:
        from pyident.cli.main import main

        main()
    except KeyboardInterrupt:
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        print("stopped", file=sys.stderr)
        raise SystemExit(128 + signal.SIGINT) from None


def _once_more(lost: "sys.UnraisableHookArgs") -> None:
    """Ask again for a Ctrl-C, or a request to terminate, that Python lost.

    What is raised in a destructor, or in a callback of an import or of C, is only reported there.
    """
    import os
    import signal
    import threading

    asked = {KeyboardInterrupt: signal.SIGINT, SystemExit: signal.SIGTERM}.get(lost.exc_type)
    if asked is None:
        sys.__unraisablehook__(lost)
        return
    again = threading.Timer(0.05, os.kill, (os.getpid(), asked))
    again.daemon = True
    again.start()


if __name__ == "__main__":
    main()
