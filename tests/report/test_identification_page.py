"""The page of an identification says what the numbers are, and numbers agree with closed forms."""

import json
import re
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner
from one_joint import PERIOD, one_joint

import pyident as pi
from flexmodels.files.robot_file import save_robot
from pyident.cli.main import main
from pyident.estimation.least_squares import solve
from pyident.estimation.residuals import correlations, joint_residuals, torque_error
from pyident.logs.log import Log
from pyident.regression.reduced import reduce

ROBOT = replace(one_joint(), controller=None)
INERTIA = 1.1  # about the joint, with the motor's


def recorded(seed: int, added: float = 0.0, slow: float = 0.0) -> Log:
    """tau = J ddq + 2 dq + sign dq, closed form of an upright hinge, with noise or a slow torque added."""
    rng, time = np.random.default_rng(seed), np.arange(3000) * PERIOD
    q, dq, ddq = (np.zeros_like(time) for _ in range(3))
    for f in (0.37, 0.9, 1.7, 3.1):
        omega, phase = 2 * np.pi * f, rng.uniform(0, 2 * np.pi)
        q += 0.3 * np.sin(omega * time + phase)
        dq += 0.3 * omega * np.cos(omega * time + phase)
        ddq -= 0.3 * omega**2 * np.sin(omega * time + phase)
    tau = INERTIA * ddq + 2 * dq + np.sign(dq)
    tau += added * rng.standard_normal(len(time)) + slow * np.sin(2 * np.pi * 0.21 * time)
    return Log(pd.DataFrame({"time": time, "joint1.e": q, "joint1.tau": tau}), f"log {seed}")


@pytest.fixture(scope="module")
def true():
    return ROBOT.with_parameters({"link1.J[zz]": 0.6, "joint1.J_m": 0.5})


def test_white_noise_is_white_and_a_slow_torque_is_slow(true):
    (white,) = joint_residuals(true, [recorded(1, added=0.5), recorded(2, added=0.5)])
    (slow,) = joint_residuals(true, [recorded(1, added=0.05, slow=1.0)])
    assert white.slow < 0.2 < 0.8 < slow.slow
    assert slow.frequency[np.argmax(slow.residual)] < 0.5


def test_the_error_of_known_parameters_is_the_noise(true):
    """Noise of σ under the hat of two samples has a mean square of σ² times 1/2 to 1."""
    log = recorded(3, added=0.5)
    share = 0.5 / float(np.std(log.signals(["joint1.tau"])))
    assert 0.4 * share < torque_error(true, log)["all"] / 100 < 1.2 * share


def test_correlations_are_those_of_the_normal_equations():
    """Two columns at an angle: their estimates are correlated by minus its cosine."""
    rng = np.random.default_rng(0)
    one, other, third = np.linalg.qr(rng.standard_normal((500, 3)))[0].T
    A = np.stack([one, 0.8 * one + 0.6 * other, third], axis=1)[:, None, :]
    y = (A @ [1.0, 2.0, 3.0]) + 0.01 * rng.standard_normal((500, 1))
    solution = solve(reduce([(A, y)], ("row",), ("a", "b", "c")))
    (r, *names), *rest = correlations(solution, ("a", "b", "c"))
    assert r == pytest.approx(-0.8, abs=1e-9)
    assert names == ["a", "b"]
    assert max(abs(r) for r, *_ in rest) < 1e-9


def test_the_command_writes_it(tmp_path):
    save_robot(ROBOT, tmp_path / "arm.toml")
    for seed in (1, 2):
        pi.write_log(recorded(seed, added=0.1), tmp_path / f"{seed}.parquet")
    words = ["identify", "arm.toml", "1.parquet", "--holdout", "2.parquet", "--prior", "arm.toml"]
    words += ["--page", "fit.html", "--json", "fit.json"]
    words = [str(tmp_path / w) if "." in w else w for w in words]
    done = CliRunner().invoke(main, words, catch_exceptions=False)
    assert done.exit_code == 0, done.output
    assert "held out: joint1" in " ".join(done.output.split())
    text = (tmp_path / "fit.html").read_text("utf-8")
    assert not re.search(r'(src|href)="(?!data:|#)', text)
    for heading in ("Errors", "Parameters", "Base parameters", "What acts alike", "What is left"):
        assert f"<h2>{heading}</h2>" in text
    (unseen,) = json.loads((tmp_path / "fit.json").read_text())["relative_error_heldout_percent"].values()
    assert f"<td>{unseen['joint1']:.3g}</td>" in text
    assert "<th>prior</th>" in text
