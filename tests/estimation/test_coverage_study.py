"""The study of intervals keeps what each log gave, and counts as it says."""

from dataclasses import asdict

import numpy as np
import pandas as pd
import pytest
from studies.coverage import study
from studies.coverage.study import Estimate, deviations, run

from flexmodels.files.robot_file import load_robot

ROBOT = load_robot("four_link")
TRUE = np.array(list(ROBOT.linear_parameters.values()))


def _drawn(rng: np.random.Generator, share: float) -> Estimate:
    """Estimates whose intervals are `share` as wide as their errors."""
    std = np.full(len(TRUE), 0.01)
    std[3] = np.inf
    return Estimate(list(TRUE + std.min() / share * rng.standard_normal(len(TRUE))), list(std))


@pytest.mark.parametrize(("share", "coverage"), [(1.0, 0.95), (0.5, 0.673), (2.0, 0.99991)])
def test_coverage_is_what_the_intervals_deserve(share, coverage):
    rng = np.random.default_rng(3)
    table = deviations(ROBOT, [_drawn(rng, share) for _ in range(200)])
    assert len(table) == len(TRUE) - 1
    assert float(table["coverage"].to_numpy().mean()) == pytest.approx(coverage, abs=0.01)
    assert float(table["spread"].to_numpy().mean()) == pytest.approx(1 / share, rel=0.02)


def test_a_stopped_study_goes_on_where_it_was(tmp_path, monkeypatch):
    asked, rng = [], np.random.default_rng(0)

    def stopped(robot, simulate, level, seed):
        if len(asked) == 3:
            raise KeyboardInterrupt
        return estimates(robot, simulate, level, seed)

    def estimates(robot, simulate, level, seed):
        asked.append((level, seed))
        return {"any": asdict(_drawn(rng, 1.0))}

    monkeypatch.setattr(study, "_estimates", stopped)
    with pytest.raises(KeyboardInterrupt):
        run(tmp_path, lambda share: None, runs=2)
    monkeypatch.setattr(study, "_estimates", estimates)
    result = run(tmp_path, lambda share: None, runs=2)
    assert asked == [(2e-6, 0), (2e-6, 1), (1e-5, 0), (1e-5, 1)]
    assert len(result.rows) == 8
    again = pd.read_csv(tmp_path / "coverage.csv")
    assert run(tmp_path, lambda share: None, runs=2).rows == result.rows
    assert len(asked) == 4
    pd.testing.assert_frame_equal(pd.read_csv(tmp_path / "coverage.csv"), again)
    monkeypatch.setattr(study, "code_version", lambda own: "another")
    run(tmp_path, lambda share: None, runs=1)
    assert len(asked) == 6, "estimates of another version of the code were counted"
