"""A carriage on a rail: dry friction against a closed form, every platform, and no leaks."""

import shutil
import subprocess
import zipfile
from pathlib import Path

import numpy as np
import pytest
from fmpy import read_model_description, simulate_fmu

from flexfmu.build import export_fmu
from flexfmu.code.compilation import PLATFORMS
from flexfmu.simulate import LoadedFmu
from flexmodels.experiment import Experiment
from flexmodels.files.robot_file import load_robot
from flexmodels.mechanics.plant import equations

RAIL = """
name = "rail"
[controller]
rate = 100.0
Kp = [4000.0]
Kd = [0.0]
Ki = [0.0]
[[joint]]
kind = "prismatic"
x = [1.0, 0.0, 0.0]
y = [0.0, 1.0, 0.0]
J_m = 5.0
coulomb = 20.0
viscous = 0.0
[[link]]
m = 95.0
ms = [0.0, 0.0, 0.0]
J = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0]
"""
SPRING, COULOMB, MASS, PERIOD = 4000.0, 20.0, 100.0, 0.01


@pytest.fixture
def rail(tmp_path):
    (tmp_path / "rail.toml").write_text(RAIL)
    return load_robot(tmp_path / "rail.toml")


def event_exact(reference):
    """The carriage behind its spring, parabola by parabola: positions, speeds, number of sticks."""
    x, v, mode, sticks, out = 0.0, 0.0, 0, 0, [(0.0, 0.0)]
    for r in reference[:-1]:
        force, left = SPRING * (r - x), PERIOD
        while left > 0:
            if mode == 0 and abs(force) <= COULOMB:
                break
            if mode == 0:
                mode = 1 if force > 0 else -1
            a = (force - mode * COULOMB) / MASS
            stop = -v / a if a * v < 0 else np.inf
            h = min(left, stop)
            x, v, left = x + v * h + a * h * h / 2, v + a * h, left - h
            if h == stop:
                v, mode, sticks = 0.0, 0, sticks + 1
        out.append((x, v))
    return (*np.array(out).T, sticks)


def by_co_simulation(path, time, pull):
    with LoadedFmu(path) as fmu:
        log = fmu.simulate(Experiment(time, pull[:, None], 0 * time[:, None]), outputs=("joint1.de",))
    return log["joint1.e"].to_numpy(), log["joint1.de"].to_numpy()


def by_model_exchange(path, time, pull):
    signals = np.zeros(len(time), dtype=[("time", float), ("joint1.r", float), ("joint1.tau_ff", float)])
    signals["time"], signals["joint1.r"] = time, pull
    result = simulate_fmu(
        str(path),
        fmi_type="ModelExchange",
        stop_time=time[-1],
        output_interval=PERIOD,
        relative_tolerance=1e-8,
        input=signals,
        output=["joint1.e", "joint1.de"],
    )
    last = np.searchsorted(result["time"], time + 1e-9) - 1
    return result["joint1.e"][last], result["joint1.de"][last]


@pytest.mark.parametrize("simulated", [by_co_simulation, by_model_exchange])
def test_stick_slip_against_the_event_exact_solution(rail, tmp_path, simulated):
    time = np.arange(801) * PERIOD
    pull = 0.02 * time + 0.012 * np.sin(2 * np.pi * 0.7 * time)
    path = export_fmu(equations(rail), tmp_path / "rail.fmu")
    expected, speed, sticks = event_exact(pull)
    x, v = simulated(path, time, pull)
    assert np.abs(x - expected).max() < 1e-4 * np.ptp(expected)
    rests = np.flatnonzero(np.diff((v == 0).astype(int)) == 1)
    expected_rests = np.flatnonzero(np.diff((speed == 0).astype(int)) == 1)
    assert sticks >= 5
    np.testing.assert_array_equal(rests, expected_rests)


def test_a_constant_force_gives_a_parabola(rail, tmp_path):
    path = export_fmu(equations(rail), tmp_path / "rail.fmu")
    time = np.arange(101) * PERIOD
    with LoadedFmu(path) as fmu:
        log = fmu.simulate(Experiment(time, np.zeros((101, 1)), np.full((101, 1), 70.0)), {"joint1.Kp": 0.0})
    np.testing.assert_allclose(log["joint1.e"], 0.5 * (70 - COULOMB) / MASS * time**2, atol=1e-12)
    np.testing.assert_allclose(log["tip.x"], log["joint1.e"], atol=1e-15)


@pytest.mark.slow
def test_one_file_for_every_platform(rail, tmp_path):
    pytest.importorskip("ziglang", reason="the compiler for other platforms is not installed")
    path = export_fmu(equations(rail), tmp_path / "all.fmu", fmi=3, platforms="all")
    names = zipfile.ZipFile(path).namelist()
    for platform in PLATFORMS:
        assert f"binaries/{platform.folder(3)}/rail{platform.suffix}" in names
    assert not [n for n in names if n.endswith((".pdb", ".lib"))]
    time = np.arange(11) * PERIOD
    with LoadedFmu(path) as fmu:
        assert len(fmu.simulate(Experiment(time, 0.1 * time[:, None], 0 * time[:, None]))) == 11


def test_a_thousand_lives_leak_nothing(rail, tmp_path):
    """Instantiate, run, save, restore, free, a thousand times in a C host under the sanitizers."""
    if not shutil.which("gcc"):
        pytest.skip("needs gcc")
    path = export_fmu(equations(rail), tmp_path / "rail.fmu")
    with zipfile.ZipFile(path) as archive:
        archive.extractall(tmp_path / "rail")
    folder = tmp_path / "rail" / "sources"
    token = read_model_description(str(path)).guid
    program = tmp_path / "host"
    flags = [
        "-std=c99",
        "-g",
        "-DFMI2_OVERRIDE_FUNCTION_PREFIX",
        "-fsanitize=address,undefined",
        f'-DTOKEN="{token}"',
        "-I.",
    ]
    files = [str(Path(__file__).parents[2] / "fmu" / "host.c"), *map(str, sorted(folder.glob("*.c")))]
    built = subprocess.run(
        ["gcc", *flags, *files, "-lm", "-o", str(program)], cwd=folder, capture_output=True, text=True
    )
    if "asan" in built.stderr:
        pytest.skip("gcc's sanitizers are not installed")
    assert built.returncode == 0, built.stderr
    done = subprocess.run([str(program)], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "1000 lives" in done.stdout
