"""The command `pyident`. Processes that it starts import this file once more: let it import nothing else."""


def main() -> None:
    """Run the command; Ctrl-C at any time ends in one line, a request to terminate closes what is open."""
    import signal
    import sys

    def terminate(*_: object) -> None:
        raise SystemExit(128 + signal.SIGTERM)

    signal.signal(signal.SIGTERM, terminate)
    try:
        from pyident.cli.main import main

        main()
    except KeyboardInterrupt:
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        print("stopped", file=sys.stderr)
        raise SystemExit(128 + signal.SIGINT) from None


if __name__ == "__main__":
    main()
