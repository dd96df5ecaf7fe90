"""Options that do not belong together end in a sentence before anything is computed."""

import pytest
from click.testing import CliRunner
from two_link_logs import TWO_LINK

from pyident.cli.main import main


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (("identify", "--parameters", "k"), "--parameters and --interface belong to an FMU"),
        (("identify", "--set", "joint1.coulomb=1"), "--set belongs to an FMU as the model, or to a robot"),
        (("identify", "--robust", "--refine"), "--refine does without them"),
        (("identify", "--prior", "--refine"), "--refine does not use it"),
        (("identify", "--holdout", "x.csv", "--refine"), "--holdout judges the regression's torques"),
        (("diagnose", "--parameters", "k"), "--parameters, --interface and --set belong to an FMU"),
    ],
)
def test_they_are_refused(words, sentence, tmp_path, monkeypatch):
    for verb in ("identify", "refine", "diagnose"):
        monkeypatch.setattr(f"pyident.{verb}", None)  # calling it would be a fault, with exit code 70
    log = tmp_path / "log.csv"
    log.write_text("time\n0\n")
    command, *options = words
    if "--prior" in options:
        options.insert(options.index("--prior") + 1, str(TWO_LINK))
    done = CliRunner().invoke(main, [command, str(TWO_LINK), str(log), *options])
    assert done.exit_code == 2, done.output
    assert sentence in " ".join(done.output.split())
