"""The page of a diagnosis: says what the diagnosis says, alone in its file."""

import re
from dataclasses import replace
from html import unescape
from html.parser import HTMLParser
from math import inf

import pytest

from flexmodels.effects import CATALOGUE
from pyident.diagnosis.result import Diagnosis, Finding, Limit, Named, Row, Stage
from pyident.report.diagnosis_page import write_diagnosis
from pyident.report.law_sheet import law_sheet
from pyident.report.wording import measured, number, percent, times, unit

BANDS = ((0.0, 0.5), (0.5, 24.95))
ROWS = (
    Row("joint1.e", "joint1", "motor", BANDS, (1.25, 0.0625), (12.5, 1.25)),
    Row("joint2.e", "joint2", "motor", BANDS, (0.11, 0.12), (1.1, 1.2)),
    Row("joint1.eps[1]", "joint1", "transmission", BANDS, (0.21, 0.22), (2.1, 1.05)),
    Row("joint1.eps[2]", "joint1", "link", BANDS, (0.3, 0.0), (0.9, 0.0)),
)
STRIBECK = Named(
    "stribeck",
    "joint1",
    {"level": 8.1234, "velocity": 0.0517},
    {"level": 0.25, "velocity": inf},
    {"level": "N.m", "velocity": "rad/s"},
    91.5,
    beside_percent=0.0,
    nonlinear=("velocity",),
)
PRESLIDING = Named(
    "presliding",
    "joint1",
    {"level": 7.0},
    {"level": 0.2},
    {"level": "N.m"},
    64.25,
    beside_percent=0.4,
)
LIMITS = (
    Limit("backlash", "joint1", {"stiffness": 1181.7}, {"stiffness": "N.m/rad"}, 0.3),
    Limit(
        "payload",
        "joint2",
        {"mass": 3.0},
        {"mass": "kg"},
        120.0,
        "the logs do not cover what it needs: poses",
        "with and without",
    ),
)
FINDING = Finding((STRIBECK,), 1 / 21, 88.8, 97.25, 41.5, replicas=20)
MISSING = Diagnosis(
    robot="arm",
    logs=("a log.csv", "b.csv"),
    heldout=("c.csv",),
    verdict="missing_effect",
    sentence="stribeck at joint1 is missing: it explains 97 % of what exceeds the floor.",
    findings=(FINDING,),
    localised=("joint1", "motor"),
    limits=LIMITS,
    rows=ROWS,
    excess=7.25,
    remaining=1.17,
    ranking=(STRIBECK, PRESLIDING),
    notes=("the clock of a log.csv jumps at 3.2 s",),
    noise={"joint1.e": 2e-6},
    stages=(Stage(None, 7.25), Stage(STRIBECK, 1.17)),
)
TIE = replace(
    MISSING,
    verdict="cannot_tell",
    sentence="stribeck at joint1 or presliding at joint1: these logs cannot tell which.",
    findings=(
        replace(FINDING, tie=(STRIBECK, PRESLIDING), experiment="slow reversals of growing amplitude"),
    ),
)
UNEXPLAINED = replace(
    MISSING,
    verdict="unexplained",
    sentence="Something is missing at joint1, motor side, but no effect of the catalogue explains it.",
    findings=(),
    depends_on=("The residual repeats with time at 7.5 Hz.",),
    stages=(Stage(None, 7.25),),
    remaining=7.25,
)
NOTHING = replace(
    MISSING,
    verdict="nothing_detectable",
    sentence="Nothing is missing that these logs could show.",
    findings=(),
    localised=None,
    excess=1.02,
    remaining=1.02,
    stages=(Stage(None, 1.02),),
)


class Reader(HTMLParser):
    """Visible text, whatever would be loaded, and anchors and links of a page."""

    def __init__(self, html: str):
        super().__init__()
        self.text, self.loaded, self.ids, self.links, self.hidden = "", [], set(), [], False
        self.feed(html)

    def handle_starttag(self, tag, attrs):
        found = dict(attrs)
        self.hidden = tag in ("script", "style")
        self.text += " " if tag in ("td", "th", "p", "li", "dd") else ""
        self.loaded += [found[key] for key in ("src", "srcset", "data", "poster", "action") if key in found]
        self.loaded += [found.get("href")] if tag in ("link", "base", "image", "use") else []
        self.ids.add(found.get("id"))
        self.links += [found["href"]] if tag == "a" else []

    def handle_endtag(self, tag):
        self.hidden = False

    def handle_data(self, data):
        if not self.hidden:
            self.text += data


@pytest.fixture
def page(tmp_path):
    def read(diagnosis, **options) -> tuple[str, Reader, str]:
        html = write_diagnosis(diagnosis, tmp_path / "page.html", **options).read_text(encoding="utf-8")
        reader = Reader(html)
        return html, reader, re.sub(r"\s+", " ", reader.text)

    return read


@pytest.mark.parametrize("diagnosis", [MISSING, TIE, UNEXPLAINED, NOTHING], ids=lambda d: d.verdict)
def test_every_verdict_is_said_and_nothing_is_loaded(page, diagnosis):
    html, reader, text = page(diagnosis)
    assert diagnosis.sentence in text
    assert f"{diagnosis.excess:.2f} ×" in text
    assert "the clock of a log.csv jumps at 3.2 s" in text
    assert reader.loaded == []
    own = re.sub(r"<script>.*?</script>", "", html, flags=re.S)
    assert "@import" not in own
    assert "url(" not in own
    assert not [link for link in reader.links if not link.startswith("#")]
    assert {link[1:] for link in reader.links} <= reader.ids  # every link has its target


def test_the_numbers_of_a_finding(page):
    _, _, text = page(MISSING)
    for told in ("97.2", "41.5", "none of 20", "p = 0.048", "1.17 ×", "91.5", "64.2"):
        assert told in text, told
    assert "8.12 N m" in text
    assert "0.05170 rad/s" in text
    assert "presliding at joint1: 64.2 % by itself, 0.4 % beside this finding" in text.replace("\u00a0", " ")


def test_commands_quote_their_files_and_name_the_model_as_given(page):
    _, _, text = page(MISSING, model="robots/arm.toml")
    held = "'a log.csv' b.csv --holdout c.csv"
    assert f"pyident add robots/arm.toml stribeck --joint 1 {held} -o arm_stribeck.toml" in text
    assert f"pyident diagnose arm_stribeck.toml {held}" in text


def test_a_tie_offers_each_member_and_the_experiment(page):
    _, _, text = page(TIE)
    assert "pyident add arm stribeck --joint 1" in text
    assert "pyident add arm presliding --joint 1" in text
    assert "slow reversals of growing amplitude" in text


def test_unexplained_names_the_place_and_what_it_depends_on(page):
    _, _, text = page(UNEXPLAINED)
    assert "joint1, motor side" in text
    assert "12.5 times the floor, 1.25 N m rms" in text
    assert "The residual repeats with time at 7.5 Hz." in text
    assert "pyident add " not in text


def test_nothing_detectable_says_what_would_have_been_seen(page):
    _, _, text = page(NOTHING)
    assert "1 182 N m/rad" in text.replace("\u202f", " ")
    assert "the logs do not cover what it needs: poses" in text
    assert "pyident add " not in text


def test_names_are_escaped(page):
    bad = '<img src="x.png">&</script><script>alert(1)</script>'
    wrong = replace(STRIBECK, effect=bad)
    html, reader, text = page(
        replace(
            MISSING,
            robot=bad,
            logs=(bad,),
            sentence=bad,
            notes=(bad,),
            findings=(replace(FINDING, tie=(wrong,)),),
            ranking=(wrong,),
            rows=tuple(replace(row, joint=bad) for row in ROWS),
            stages=(Stage(None, 2.0), Stage(wrong, 1.0)),
        )
    )
    assert reader.loaded == []
    assert "<script>alert(1)" not in html
    assert '<img src="x.png">&' in unescape(text)


def test_an_effect_that_is_found_twice_is_added_once(page):
    again = replace(STRIBECK, values={"level": 1.0, "velocity": 0.4})
    _, _, text = page(replace(MISSING, findings=(FINDING, replace(FINDING, tie=(again,)))))
    assert text.count("pyident add arm stribeck") == 1
    assert "was found more than once" in text


def test_a_page_that_cannot_be_written_leaves_nothing(tmp_path):
    with pytest.raises(FileNotFoundError):
        write_diagnosis(MISSING, tmp_path / "no" / "page.html")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("effect", CATALOGUE.values(), ids=lambda e: e.name)
def test_every_law_has_a_sheet_with_formulas(effect):
    sheet = law_sheet(effect)
    assert sheet.formulas
    shown = "".join(str(f.mathml) for f in sheet.formulas) + " ".join(f.place for f in sheet.formulas)
    assert all(p.name in re.sub(r"\\_", "_", shown) for p in effect.parameters)


@pytest.mark.parametrize(
    ("held_out", "words"),
    [
        (216.0, "it takes 100 % of what exceeds the floor, with"),
        (-150.0, "it adds 150 % of what exceeds the floor, with"),
    ],
)
def test_nothing_takes_more_than_all_of_an_excess(page, held_out, words):
    more = replace(FINDING, share_percent=105.0, heldout_gain_percent=held_out)
    _, _, text = page(replace(MISSING, findings=(more,)))
    assert "What it explains 100 % of what" in text
    assert words in text
    assert "216" not in text


@pytest.mark.parametrize(
    ("said", "expected"),
    [
        (number(1.825e9), "1.82 × 10⁹"),
        (number(-0.0123456), "−0.0123"),
        (number(0.0), "0"),
        (number(1e-7, 2), "1.0 × 10⁻⁷"),
        (measured(20.12345, 0.0123), "20.123"),
        (times(1903.7), "1\u202f904"),
        (percent(0.01), "<\u00a00.1\u00a0%"),
        (percent(-0.01), "0.0\u00a0%"),
        (unit("N.m.s2/rad2"), "N m s²/rad²"),
        (unit("1"), ""),
    ],
)
def test_wording(said, expected):
    assert said == expected
