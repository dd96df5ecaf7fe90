"""Hidden torques of known form, and what is said about them."""

import re
from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from one_joint import one_joint

from flexfmu.build import export_fmu
from flexfmu.simulate import LoadedFmu
from flexmodels.effects import effects_of
from flexmodels.experiment import Experiment, identification
from flexmodels.mechanics.plant import equations
from flexmodels.robot import Robot
from flexmodels.settings.motions import Identification, Multisine
from pyident.diagnosis.base.projection import Base
from pyident.diagnosis.base.residual_over_floor import Examination, examine
from pyident.diagnosis.base.setting import set_up
from pyident.diagnosis.next_steps import _not_looked_at
from pyident.diagnosis.result import Place
from pyident.diagnosis.unexplained import formula as symbolic
from pyident.diagnosis.unexplained import unexplained as module
from pyident.diagnosis.unexplained.formula import Draft, symbolic_law
from pyident.diagnosis.unexplained.periodic import Over
from pyident.diagnosis.unexplained.residual_terms import Dependence, RowSearch, excess
from pyident.diagnosis.unexplained.unexplained import Unexplained, clause, depends_on
from pyident.logs.log import Log
from pyident.regression.candidate_columns import effect_columns
from pyident.rules.rules import RULES
from pyident.simulation.fmu_runs import runs_here

NOISE = 1e-5


def arm() -> Robot:
    plan = Identification((4.0,), 4.0, 16.0, Multisine((1.0,), 40, 0.5, 20.0))
    return one_joint().with_settings(identification=plan)


@pytest.fixture(scope="module")
def fmu(tmp_path_factory):
    path = export_fmu(equations(arm()), tmp_path_factory.mktemp("arm") / "arm.fmu", light=True)
    with LoadedFmu(path) as loaded:
        yield loaded


def bump(e):
    """Passed forward and backward, at another speed than elsewhere: no function of time, speed or load."""
    return 2 * np.exp(-(((e - 1) / 0.8) ** 2))


def recorded(fmu, hidden, position_error=lambda e: 0 * e) -> Log:
    """The arm under a torque that the log does not tell of: hidden(e, de, t), at the samples."""
    plan = identification(arm())
    wander = 1.2 * (1 - np.cos(2 * np.pi * plan.time / 2.9)) + 0.8 * np.sin(2 * np.pi * plan.time / 7.3)
    plan = replace(plan, reference=0.5 * plan.reference + wander[:, None])
    first = fmu.simulate(plan)
    e = first["joint1.e"].to_numpy(float)
    force = hidden(e, np.gradient(e, plan.time), plan.time)
    frame = fmu.simulate(Experiment(plan.time, plan.reference, plan.feedforward - force[:, None]))
    frame["joint1.tau"] += force
    frame["joint1.e"] += position_error(frame["joint1.e"])
    frame["joint1.e"] += NOISE * np.random.default_rng(3).standard_normal(len(frame))
    return Log(frame, "hidden.csv")


def said(log: Log) -> tuple[Examination, Unexplained]:
    setting = set_up(arm(), [log])
    with runs_here(arm()) as pool:
        examination = examine(setting, pool, lambda _: None)
        return examination, depends_on(examination, pool)


@pytest.fixture(scope="module")
def bumpy(fmu):
    return said(recorded(fmu, lambda e, de, t: bump(e)))


def test_nothing_hidden_depends_on_nothing(fmu):
    _, found = said(recorded(fmu, lambda e, de, t: 0 * t))
    assert found.dependences == ()


def test_a_hum_is_found_at_its_frequency(fmu):
    _, found = said(recorded(fmu, lambda e, de, t: 0.8 * np.sin(2 * np.pi * 6.37 * t + 1)))
    first = found.dependences[0]
    assert (first.on, first.form) == ("time", "frequency")
    assert first.at == pytest.approx(6.37, abs=0.01)
    assert first.amplitude == pytest.approx(0.8, rel=0.05)
    assert first.share_percent > 90
    assert "motor side of joint 1: depends on a frequency of 6.37" in found.sentences[0]


def test_a_brake_is_said_to_drag_from_an_instant_on(fmu):
    found = said(recorded(fmu, lambda e, de, t: 0.8 * (t > 7.13) * np.tanh(20 * de)))[1]
    first = found.dependences[0]
    assert (first.on, first.form) == ("time", "friction")
    assert first.amplitude == pytest.approx(0.8, rel=0.05)
    instant = re.search(r"depends on time, from about ([\d.]+) s on, as friction", found.sentences[0])
    assert instant is not None
    assert float(instant[1]) == pytest.approx(7.13, abs=0.15)


def test_a_force_that_grows_with_time_has_no_instant(fmu):
    found = said(recorded(fmu, lambda e, de, t: 0.1 * t * np.tanh(20 * de)))[1]
    assert found.dependences[0].on == "time"
    assert "time, as friction" in found.sentences[0]


def test_a_force_over_the_position_is_drawn(bumpy):
    _, found = bumpy
    first = found.dependences[0]
    assert (first.on, first.form) == ("joint1.e", "force")
    assert first.share_percent > 90
    assert "position of joint 1 (explains" in found.sentences[0]
    assert first.x[np.argmax(first.force)] == pytest.approx(1, abs=0.2)
    assert np.corrcoef(first.force, bump(first.x))[0, 1] > 0.95


def test_what_thresholds_change_of_a_force_with_a_weak_wave_under_it(fmu):
    """A wave of 5 % is the only thing that half or twice as much of them hides."""
    examination, usual = said(recorded(fmu, lambda e, de, t: bump(e) + 0.3 * np.sin(2 * np.pi * 6.37 * t)))
    both = [("joint1.e", "force"), ("time", "frequency")]
    assert _names(usual) == both

    def changed(group: str, name: str, factor: float) -> Unexplained:
        rules = getattr(RULES, group)
        rules = replace(RULES, **{group: replace(rules, **{name: factor * getattr(rules, name)})})
        other = replace(examination, setting=replace(examination.setting, rules=rules))
        with runs_here(arm()) as pool:
            return depends_on(other, pool)

    for group, name in (("unexplained", "beyond"), ("periodic", "quiet"), ("periodic", "left")):
        assert _names(changed(group, name, 0.5)) == _names(changed(group, name, 2.0)) == both
    assert _names(changed("unexplained", "material", 0.5)) == both
    assert _names(changed("unexplained", "material", 2.0)) == both[:1]


def _names(found: Unexplained) -> list[tuple[str, str]]:
    return [(d.on, d.form) for d in found.dependences]


def test_an_order_of_the_angle_is_found(fmu):
    _, found = said(recorded(fmu, lambda e, de, t: 0.6 * np.cos(37 * e)))
    first = found.dependences[0]
    assert (first.on, first.form) == ("joint1.e", "order")
    assert first.at == pytest.approx(37, abs=0.3)


def test_a_misread_angle_is_told_from_a_torque(fmu):
    log = recorded(fmu, lambda e, de, t: 0 * t, position_error=lambda e: 2e-3 * np.sin(9 * e))
    _, found = said(log)
    first = found.dependences[0]
    assert (first.on, first.form) == ("joint1.e", "misread")
    assert first.at == pytest.approx(9, abs=0.2)
    assert first.amplitude == pytest.approx(2e-3, rel=0.1)


def test_a_draft_is_an_effect_file(bumpy, tmp_path):
    pytest.importorskip("pyoperon")
    examination, found = bumpy
    draft = symbolic_law(examination, found.dependences)
    assert isinstance(draft, Draft)
    assert draft.share_percent > 80
    (tmp_path / "drafted.py").write_text(draft.text)
    own = effects_of([str(tmp_path / "drafted.py")])
    robot = examination.setting.robot
    robot = replace(robot, joints=tuple(replace(joint, own=own) for joint in robot.joints))
    motion = examination.logs[0].part.motion
    columns = effect_columns(robot, 1, "drafted", motion)
    force = sum(p.start * columns[p.name][0] for p in own["drafted"].linear)
    truth = bump(motion.q[:, 0])
    assert np.corrcoef(np.asarray(force), truth)[0, 1] > 0.8


def test_without_the_package_a_sentence_says_so(bumpy, monkeypatch):
    monkeypatch.setattr(symbolic, "find_spec", lambda _: None)
    examination, found = bumpy
    assert symbolic_law(examination, found.dependences) == symbolic.MISSING


def _dependence(form: str, *rivals: tuple[str, str]) -> Dependence:
    """Of joint 6's speed; rivals: words and signal."""
    words, signals = tuple(w for w, _ in rivals), tuple(s for _, s in rivals)
    nothing = np.zeros(0)
    more: dict[str, Any] = {"rivals": words, "rival_signals": signals}
    return Dependence(
        "joint6.e", "joint6.de", "speed of joint 6", form, 93.4, 1.0, 0.0, nothing, nothing, **more
    )


@pytest.mark.parametrize(
    ("found", "words"),
    [
        (_dependence("force"), "speed of joint 6 (explains 93 % of the excess)"),
        (_dependence("friction"), "speed of joint 6, as friction (explains 93 % of the excess)"),
        (
            _dependence("friction", ("speed of joint 6", "joint6.de"), ("time", "time")),
            "speed of joint 6, as friction or as a force of either sign "
            "(explains 93 % of the excess, as well as time)",
        ),
    ],
)
def test_the_form_of_a_dependence_is_said_once(found, words):
    assert clause(found, first=True) == words


def test_the_next_equation_is_looked_at_where_the_worst_one_shows_nothing(monkeypatch):
    """Of three that exceed their floor by 5, 8 and 1, the first two."""

    class Blind:
        spectra: tuple[()] = ()

        def __init__(self, examination, base, *_):
            self.base = base

        def run(self, floor):
            return []

    monkeypatch.setattr(module, "RowSearch", Blind)
    monkeypatch.setattr(module, "_pretended_by_replicas", lambda *_: np.zeros((0, 0)))
    monkeypatch.setattr(module, "_happened", lambda *_: [])
    base = Base(np.zeros(0), np.zeros((0, 0)), [], [np.sqrt(np.array([[6.0], [9.0], [2.0]]))])
    three = SimpleNamespace(q=[SimpleNamespace(joint=k, side="motor") for k in (1, 2, 3)])
    setting: Any = SimpleNamespace(rules=RULES, robot=three)
    examination: Any = SimpleNamespace(setting=setting, base=base, floor_energies=np.ones(3))
    found = depends_on(examination, cast(Any, None))
    assert found.rows == (1, 0)
    assert [s.split(":")[0] for s in found.sentences] == ["motor side of joint 2", "motor side of joint 1"]
    assert depends_on(examination, cast(Any, None), among=[0, 2]).rows == (0,)  # of the third too little


@pytest.mark.parametrize(
    ("states", "said"),
    [
        (
            ["unexplained"] * 3,
            ["motor side of joint 3: not looked at further, as less exceeds the floor there"],
        ),
        (["unexplained", "unexplained", "in_order"], []),
    ],
)
def test_what_is_left_unexplained_and_not_looked_at_is_named(states, said):
    three: Any = SimpleNamespace(q=[SimpleNamespace(joint=k, side="motor") for k in (1, 2, 3)])
    places = [Place(f"joint{k}", "motor", state, (3.0, 3.0), 1.0) for k, state in enumerate(states, start=1)]
    assert _not_looked_at(three, places, (1, 0)) == said
    alone = _not_looked_at(three, places, ())
    assert all(line.endswith("as they exceed their floors in some frequencies only") for line in alone)
    assert "motor side of joint 1 and motor side of joint 2" in alone[0]


def test_an_equation_below_its_floor_takes_nothing_from_another():
    """A residual of 2 over a floor of 1 exceeds it by 3, whatever another equation leaves."""
    residual = np.array([[2.0, 0.0], [0.0, 1.0]])
    base = Base(np.zeros(0), np.zeros((0, 0)), [], [residual])
    np.testing.assert_allclose(excess(base, np.array([1.0, 9.0])), [3.0, 0.0])


@pytest.mark.parametrize(("order", "said"), [(6.0, True), (12.0, False)])
def test_an_order_of_too_few_periods_is_said_to_be_one(order, said):
    """Angles of 2 rad hold 1.9 periods of an order of 6, no ripple yet, and 3.8 of one of 12."""
    angles = [np.linspace(0.0, end, 9)[:, None] for end in (1.0, 2.0)]
    logs = [SimpleNamespace(part=SimpleNamespace(motion=SimpleNamespace(q=q))) for q in angles]
    told = RowSearch._too_few(cast(Any, SimpleNamespace(logs=logs)), Over("order", 0, 0), order)
    assert ("no log passes more than 1.9 periods" in told) == said
