"""Which law would take a stretch: the hidden one leads, and what is not there is refused first."""

import json

import numpy as np
import pytest
from click.testing import CliRunner
from one_joint_logs import recorded

from pyident.cli.main import main
from pyident.diagnosis.stretches.ranking import Ranking, Share
from pyident.diagnosis.stretches.waves import LawWave
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
    empty = Explained(Ranking("joint1.e", "a.parquet", (0.0, 1.0), None, 2.0, 0.0, 2.0, ()))
    assert empty.headline() == "joint1.e of a.parquet, 0 to 1 s: no law of the catalogue acts there."
    assert empty.to_frame().empty
    below = Explained(Ranking("joint1.e", "a.parquet", (0.0, 1.0), (0.0, 2.0), 0.9, 0.0, 0.9, ()))
    assert below.headline().endswith("0 to 2 Hz: " + NOTHING)
    assert "there is nothing to explain" in below.summary()


@pytest.mark.parametrize(
    ("own", "leaves", "percent", "words"),
    [
        (
            98.7,
            2.61,
            117.0,
            "stribeck at joint2 takes all of what new values of the model's own laws leave over",
        ),
        (98.7, 2.61, 117.0, "take 99 % of what exceeds the floor, and leave 2.6 times the floor."),
        (99.9, 1.2, 80.0, "takes 80 % of what new values of the model's own laws leave over the floor."),
        (99.9, 1.2, 80.0, "take nearly all of what exceeds the floor, and leave 1.2 times the floor."),
        (100.2, 0.9, 1e9, "values are off, and nothing is left for a law."),
    ],
)
def test_shares_are_of_what_the_models_own_laws_leave(own, leaves, percent, words):
    """No share above 100 %, and none of what is no excess."""
    law = LawWave("stribeck", "joint2", {}, {}, "", {})
    share = Share(law, percent, np.zeros(1), np.zeros(1), True)
    text = str(
        Explained(Ranking("joint2.e", "a.csv", (0.0, 1.0), None, 9.0, own, leaves, (share,))).summary()
    )
    assert words in " ".join(text.split())
    assert (" 100 %" in text) == (percent == 117.0)
    assert f"{percent:.0f}" not in text or percent == 80.0
