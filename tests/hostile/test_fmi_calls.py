"""Random sequences of FMI calls on a build with address and undefined-behaviour sanitizers.

Here a joint and few sequences; in full, by `make fuzz`, an arm of two joints and many.
"""

import shutil
import subprocess
import zipfile
from pathlib import Path

import pytest
from hostile_run import FULL, counted

from flexfmu.build import export_fmu
from flexmodels.files.robot_file import load_robot
from flexmodels.mechanics.plant import equations

CALLER = Path(__file__).with_name("fmi_calls.c")
SEQUENCES, CALLS = (100, 2000) if FULL else (8, 1000)
JOINT = """name = "joint"
tip = [0.0, 0.0, 0.4]
[controller]
rate = 250.0
Kp = [9000.0]
Kd = [350.0]
Ki = [60000.0]
[[joint]]
origin = [0.0, 0.0, 0.3]
x = [0.0, 1.0, 0.0]
y = [0.0, 0.0, 1.0]
J_m = 2.5
coulomb = 15.0
viscous = 10.0
k = [6.0e4]
d = [8.0]
[[link]]
m = 12.0
com = [0.01, -0.02, 0.2]
J_com = [0.3, 0.28, 0.06]
"""
GENERATED = ["-std=c99", "-O0", "-g", "-w", "-fsanitize=address,undefined", "-fno-sanitize-recover=all"]
NOT_CALLED = ("batch.c", "lanes_avx2.c", "lanes_avx512.c")

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(shutil.which("gcc") is None, reason="gcc has the sanitizers"),
]


@pytest.fixture(scope="module", params=[2, 3])
def caller(request, tmp_path_factory):
    folder = tmp_path_factory.mktemp("calls")
    (folder / "joint.toml").write_text(JOINT)
    robot = Path(__file__).parents[1] / "robots" / "two_link.toml" if FULL else folder / "joint.toml"
    path = export_fmu(equations(load_robot(robot)), folder / "arm.fmu", fmi=request.param)
    with zipfile.ZipFile(path) as archive:
        archive.extractall(folder, [name for name in archive.namelist() if name.startswith("sources/")])
    sources = [file for file in sorted((folder / "sources").glob("*.c")) if file.name not in NOT_CALLED]
    command = ["gcc", *GENERATED, f"-DFACE={request.param}", f"-I{folder / 'sources'}", *map(str, sources)]
    subprocess.run([*command, str(CALLER), "-o", str(folder / "calls"), "-lm"], check=True)
    return folder / "calls"


def test_no_sequence_crashes_hangs_or_is_refused_in_silence(caller):
    refused = 0
    for seed in range(SEQUENCES):
        done = subprocess.run(
            [caller, str(seed), str(CALLS)], capture_output=True, text=True, timeout=300, check=False
        )
        counted("sequences of FMI calls")
        assert done.returncode == 0, f"seed {seed}: {done.stdout[-500:]}{done.stderr[:3000]}"
        refused += int(done.stdout.split()[2])
    assert 0.1 < refused / (SEQUENCES * CALLS) < 0.95  # hostile, and yet some calls get through
