"""FMI's names of parameters are unique and indexed as arrays are; so are the names of C functions."""

import shutil
import subprocess
import zipfile
from dataclasses import replace

import pytest
from one_joint import one_joint

import pyident as pi
from flexfmu.names import fmi_name
from flexmodels.files.robot_file import load_robot, shipped


def test_arrays_are_indexed_by_numbers():
    assert fmi_name("link1.ms[x]") == "link1.ms[1]"
    assert fmi_name("link12.J[yz]") == "link12.J[2,3]"
    assert fmi_name("joint2.k[3]") == "joint2.k[3]"
    assert fmi_name("joint1.stribeck.velocity") == "joint1.stribeck.velocity"


def test_no_two_parameters_share_a_name():
    for robot in shipped():
        names = list(load_robot(robot).parameters)
        assert len({fmi_name(name) for name in names}) == len(names)


@pytest.mark.parametrize("fmi", [2, 3])
def test_two_fmus_go_into_one_program(fmi, tmp_path):
    """Compiled as they are, without a warning, they share no name, the standard's own functions included."""
    compiler = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
    if compiler is None:
        pytest.skip("no C compiler")
    parts = []
    for name in ("first", "second"):
        path = pi.export_fmu(replace(one_joint(), name=name), tmp_path / f"{name}.fmu", fmi=fmi)
        with zipfile.ZipFile(path) as archive:
            archive.extractall(tmp_path / name)
        folder = tmp_path / name / "sources"
        command = [
            compiler,
            "-std=gnu99",
            "-O0",
            "-Wall",
            "-Werror",
            "-c",
            *(f.name for f in sorted(folder.glob("*.c"))),
        ]
        subprocess.run(command, cwd=folder, check=True)
        parts += [str(f) for f in sorted(folder.glob("*.o"))]
    calls = [f"{name}_fmi{fmi}GetVersion" for name in ("first", "second")]
    host = tmp_path / "host.c"
    host.write_text(
        "\n".join(f"const char *{call}(void);" for call in calls)
        + f"\nint main(void) {{ return {' || '.join(f'!{call}()' for call in calls)}; }}\n"
    )
    program = str(tmp_path / "host")
    built = subprocess.run(
        [compiler, str(host), *parts, "-lm", "-o", program], capture_output=True, text=True
    )
    assert built.returncode == 0, built.stderr
    assert subprocess.run([program]).returncode == 0
