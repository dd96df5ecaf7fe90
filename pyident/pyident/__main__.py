"""The command `pyident`. Processes that it starts import this file once more: let it import nothing else."""


def main() -> None:
    from pyident.cli.main import main

    main()


if __name__ == "__main__":
    main()
