"""Which law would take a stretch: the hidden one leads, and what is not there is refused first."""

import json

import pytest
from click.testing import CliRunner
from one_joint_logs import recorded

from pyident.cli.main import main
from pyident.diagnosis.stretches.ranking import Ranking
from pyident.verbs.explain import NOTHING, Explained


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("explain")
    recorded(folder)
    return folder


def explain(folder, *words: str):
    model, *logs = (str(folder / name) for name in ("robot.toml", "a.parquet", "b.parquet"))
    return CliRunner().invoke(main, ["explain", model, *logs, *words])


def test_the_hidden_law_leads_on_the_stretch(folder):
    file = folder / "explained.json"
    run = explain(folder, "--log", "b.parquet", "--span", "0.5", "2.5", "--json", str(file))
    assert run.exit_code == 0, run.output
    content = json.loads(file.read_text())
    assert (content["coordinate"], content["span"]) == ("joint1.e", [0.5, 2.5])
    assert content["log"].endswith("b.parquet")
    tied = [law["effect"] for law in content["laws"] if law["tied"]]
    assert "asymmetric_coulomb" in tied
    shares = [law["share_percent"] for law in content["laws"]]
    assert shares == sorted(shares, reverse=True)
    law = next(law for law in content["laws"] if law["effect"] == "asymmetric_coulomb")
    assert law["share_percent"] > 95
    assert law["parameters"]["coulomb"]["unit"] == "N.m"
    assert "joint1.e of b.parquet, 0.5 to 2.5 s" in run.output
    assert "A ranking of one stretch is no verdict" in run.output


def test_a_band_of_frequencies_is_ranked_by_itself(folder):
    file = folder / "band.json"
    run = explain(folder, "--equation", "joint1.e", "--band", "0.2", "3", "--json", str(file))
    assert run.exit_code == 0, run.output
    content = json.loads(file.read_text())
    assert content["band"] == [0.2, 3.0]
    assert content["laws"][0]["share_percent"] > 90
    assert ", 0.2 to 3 Hz" in " ".join(run.output.split())


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (("--equation", "joint9.e"), "there is no equation joint9.e to explain; there are joint1.e"),
        (("--log", "c.parquet"), "there is no log c.parquet to explain; there are "),
        (("--band", "3", "2"), "--band 3 2 is empty; give the lower frequency first"),
        (("--band", "900", "901"), "no frequencies from 900 to 901 Hz; the equations hold up to"),
        (("--span", "3", "2"), "--span 3 2 is empty; give the earlier time first"),
    ],
)
def test_what_is_not_there_is_one_sentence(folder, words, sentence):
    run = explain(folder, *words)
    assert run.exit_code == 2
    assert sentence in run.output


def test_nothing_to_rank_is_said():

    empty = Explained(Ranking("joint1.e", "a.parquet", (0.0, 1.0), None, 2.0, 0.0, ()))
    assert empty.headline() == "joint1.e of a.parquet, 0 to 1 s: no law of the catalogue acts there."
    assert empty.to_frame().empty
    below = Explained(Ranking("joint1.e", "a.parquet", (0.0, 1.0), (0.0, 2.0), 0.9, 0.0, ()))
    assert below.headline().endswith("0 to 2 Hz: " + NOTHING)
    assert "there is nothing to explain" in below.summary()
