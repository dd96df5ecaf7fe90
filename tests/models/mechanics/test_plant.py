"""The FMU against references that it does not share code with."""

import numpy as np
import pytest
from fmpy.validation import validate_fmu
from scipy.integrate import solve_ivp

from flexfmu.simulate import LoadedFmu
from flexmodels.experiment import Experiment, identification
from flexmodels.inputs import SimulationError
from flexmodels.mechanics.plant import equations

TIP = ["tip.x", "tip.y", "tip.z"]


def test_the_fmu_is_valid(four_link_fmu):
    assert validate_fmu(str(four_link_fmu)) == []


class EventExact:
    """Closed loop by DOP853 at 1e-11 with SciPy's event location; modes +1, -1, 0 per motor hinge."""

    def __init__(self, robot):
        self.eq, self.n = equations(robot), len(robot.coordinates)
        self.p = np.array(list(self.eq.parameters.values()))
        self.controller = robot.controller

    def rates(self, x, u, mode):
        dx, imbalance, _ = self.eq.rates(x, u, self.p, mode)
        return np.array(dx).ravel(), np.array(imbalance).ravel()

    def margins(self, x, u, mode):
        upper, lower = (np.array(v).ravel() for v in self.eq.breakaway(x, u, self.p, mode))
        _, r = self.rates(x, u, mode)
        v = x[self.n : self.n + self.eq.joints]
        return np.where(mode == 0, np.minimum(upper - r, r - lower), mode * v)

    def settle(self, x, u, mode):
        for _ in range(9):
            margin = np.where(mode == 0, self.margins(x, u, mode), 1.0)
            worst = np.argmin(margin)
            if margin[worst] >= 0:
                return
            mode[worst] = np.sign(self.rates(x, u, mode)[1][worst])

    def over_one_period(self, x, u, mode, period):
        t = 0.0
        while t < period:
            events = [lambda _, y, j=j: self.margins(y, u, mode)[j] + 1e-13 for j in range(self.eq.joints)]
            for event in events:
                event.terminal, event.direction = True, -1
            run = solve_ivp(
                lambda _, y: self.rates(y, u, mode)[0],
                (t, period), x, "DOP853", rtol=1e-11, atol=1e-13, events=events,
            )  # fmt: skip
            t, x = run.t[-1], run.y[:, -1]
            for j, times in enumerate(run.t_events):
                if len(times) and mode[j] != 0:
                    mode[j], x[self.n + j] = 0.0, 0.0
            self.settle(x, u, mode)
        return x

    def run(self, experiment, x, integral):
        c, mode, previous, states = self.controller, np.zeros(self.eq.joints), None, [x]
        for r, feedforward in zip(experiment.reference[:-1], experiment.feedforward[:-1], strict=True):
            error = r - x[: self.eq.joints]
            if previous is not None:
                integral = integral + np.array(c.Ki) * c.period * error
            slope = 0 * error if previous is None else (error - previous) / c.period
            u = np.array(c.Kp) * error + np.array(c.Kd) * slope + integral + feedforward
            previous = error
            self.settle(x, u, mode)
            x = self.over_one_period(x, u, mode, c.period)
            states.append(x)
        return np.array(states)


def test_one_second_agrees_with_an_event_exact_reference(four_link, four_link_fmu):
    experiment = identification(four_link, duration=1.0)
    with LoadedFmu(four_link_fmu) as fmu:
        log, fine = fmu.simulate(experiment), fmu.simulate(experiment, {"solver.step": 1e-4})
    reference = EventExact(four_link)
    start = np.zeros(2 * reference.n)
    start[: reference.n] = log.loc[0, list(four_link.coordinates)].to_numpy(dtype=float)
    states = reference.run(experiment, start, np.array(reference.eq.balance(start, reference.p)).ravel()[:4])
    tip = np.array([np.array(reference.eq.tip(x)).ravel() for x in states])
    assert np.abs(tip - log[TIP].to_numpy()).max() < 1e-6  # the goal is 1e-5 m
    q = fine[list(four_link.coordinates)].to_numpy()
    assert np.abs(states[:, : reference.n] - q).max() < 1e-8


def test_it_starts_in_static_equilibrium(four_link, four_link_fmu):
    time = np.arange(251) * 0.004
    pose = np.tile([0.3, 1.0, -0.7, 0.4], (251, 1))
    with LoadedFmu(four_link_fmu) as fmu:
        log = fmu.simulate(Experiment(time, pose, np.zeros_like(pose)))
    q = log[list(four_link.coordinates)].to_numpy()
    assert np.abs(q - q[0]).max() < 1e-12
    eq = equations(four_link)
    force = np.array(eq.balance(np.r_[q[0], np.zeros(16)], list(eq.parameters.values()))).ravel()
    assert np.abs(force[4:]).max() < 1e-6
    np.testing.assert_allclose(
        log.loc[0, [f"joint{k}.tau" for k in range(1, 5)]].to_numpy(float), force[:4], atol=1e-9
    )


def test_a_stuck_joint_does_not_creep(four_link, four_link_fmu):
    """60 s under a steady torque just below the Coulomb level, integrator and gains off."""
    time = np.arange(15001) * 0.004
    pose = np.tile([0.0, 1.2, -0.5, 0.0], (len(time), 1))
    push = np.tile([29.9, -44.9, 17.9, -7.9], (len(time), 1))
    off = {f"joint{k}.{gain}": 0.0 for k in range(1, 5) for gain in ("Kp", "Kd", "Ki")}
    with LoadedFmu(four_link_fmu) as fmu:
        log = fmu.simulate(Experiment(time, pose, push), off, outputs=("joint1.friction",))
        loose = fmu.simulate(Experiment(time[:251], pose[:251], 1.03 * push[:251]), off)
    e = [f"joint{k}.e" for k in range(1, 5)]
    assert np.abs(log[e].to_numpy() - pose).max() == 0.0
    assert log["joint1.friction"].iloc[-1] == pytest.approx(29.9, abs=1e-6)
    assert (np.abs(loose[e].to_numpy()[-1] - pose[0]) > 1e-4).all()


def test_friction_is_the_reaction_when_stuck_and_the_law_when_sliding(four_link, four_link_fmu):
    names = tuple(f"joint{k}.{signal}" for k in range(1, 5) for signal in ("de", "friction"))
    with LoadedFmu(four_link_fmu) as fmu:
        log = fmu.simulate(identification(four_link, duration=2.0), outputs=names)
    for k in range(1, 5):
        v, friction = log[f"joint{k}.de"].to_numpy(), log[f"joint{k}.friction"].to_numpy()
        p = four_link.parameters
        law = p[f"joint{k}.coulomb"] * np.sign(v) + p[f"joint{k}.viscous"] * v
        sliding = v != 0
        assert sliding.any()
        np.testing.assert_allclose(friction[sliding], law[sliding], rtol=1e-12)
        assert np.abs(friction[~sliding]).max(initial=0) <= p[f"joint{k}.coulomb"]


def test_the_step_may_be_any_length(four_link, four_link_fmu):
    """Twice and half the controller's period: the sampled PID does not depend on communication."""
    plan = identification(four_link, duration=0.4)
    still = Experiment(plan.time, plan.reference, 0 * plan.feedforward)
    fine_time = np.arange(2 * len(plan.time) - 1) * 0.002
    fine = Experiment(
        fine_time,
        np.column_stack([np.interp(fine_time, plan.time, r) for r in plan.reference.T]),
        np.zeros((len(fine_time), 4)),
    )
    with LoadedFmu(four_link_fmu) as fmu:
        a, b = fmu.simulate(still), fmu.simulate(fine)
    np.testing.assert_allclose(b[TIP].to_numpy()[::2], a[TIP].to_numpy(), atol=1e-7)


def test_wrong_use_is_explained(four_link, four_link_fmu, tmp_path):
    plan = identification(four_link, duration=0.1)
    with LoadedFmu(four_link_fmu) as fmu:
        with pytest.raises(SimulationError, match=r"no variable joint7\.coulomb"):
            fmu.simulate(plan, {"joint7.coulomb": 1.0})
        with pytest.raises(SimulationError, match=r"joint1\.coulomb = -1 must be at least 0"):
            fmu.simulate(plan, {"joint1.coulomb": -1.0})
    (tmp_path / "broken.fmu").write_bytes(b"not a zip")
    with pytest.raises(SimulationError, match="is not an FMU that can be read"):
        LoadedFmu(tmp_path / "broken.fmu")
