"""What the servo studies write is what the commands replay."""

from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import pyident as pi
from pyident.cli.main import main
from pyident.logs.foreign import robot_log
from pyident.logs.mapping import read_mapping
from pyident.refinement.closed_loop import ServoLog, replay_errors
from pyident.simulation.fmu_runs import runs_here

pytestmark = pytest.mark.data
STUDIES = Path(__file__).parents[3] / "studies"
CASES = {
    "xl330": ("bam_xl330/sin_sin_kp200.csv", {"servo.kp": 200.0}),
    "so101": ("so101/slow_precision.parquet", {}),
}


@pytest.mark.parametrize("name", CASES)
def test_a_replay_by_command_has_the_studys_error(data, tmp_path, name):
    log, settings = data / CASES[name][0], CASES[name][1]
    model, mapping = STUDIES / name / "start.toml", STUDIES / name / "mapping.toml"
    robot = pi.load_robot(model)
    recording = ServoLog(robot_log(log, robot, read_mapping(mapping)), settings)
    with runs_here(robot) as simulate:
        ((_, error),) = replay_errors(robot, [recording], simulate)
    output = tmp_path / "sim.parquet"
    command = ["simulate", str(model), "--experiment", str(log), "--mapping", str(mapping), "-o", str(output)]
    for key, value in settings.items():
        command += ["--set", f"{key}={value:g}"]
    result = CliRunner().invoke(main, command, catch_exceptions=False)
    assert result.exit_code == 0, result.output
    written, measured = pi.read_log(output).frame, recording.log.frame
    np.testing.assert_allclose(written["time"], measured["time"], rtol=0, atol=1e-9)
    names = [f"joint{k}.e" for k, _ in robot.numbered]
    np.testing.assert_allclose((written[names] - measured[names]).to_numpy(), error, rtol=0, atol=1e-9)
    assert np.abs(error).mean() > 1e-3  # a guess, not yet fitted
