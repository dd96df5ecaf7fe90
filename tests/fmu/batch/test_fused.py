"""The binary chooses fused operations where the processor has them; without them it says the same."""

import subprocess
import zipfile

import numpy as np
import pytest
from one_joint import one_joint, swing

import pyident as pi
from flexfmu.simulate import LoadedFmu
from flexmodels.compiling.compiler import compiler


def test_plain_operations_give_the_same_run(tmp_path):
    """Built once more from its own sources, told to leave them out."""
    path, plain = pi.export_fmu(one_joint(), tmp_path / "arm.fmu"), tmp_path / "plain.fmu"
    folder = tmp_path / "unpacked"
    with zipfile.ZipFile(path) as archive:
        archive.extractall(folder)
    (binary,) = (folder / "binaries").glob("*/*.*")
    sources = sorted((folder / "sources").glob("*.c"))
    plain_only = ["-ffp-contract=off", "-DNOT_FUSED", "-DFMI3_OVERRIDE_FUNCTION_PREFIX"]
    words = [*compiler(), "-std=gnu99", "-O1", *plain_only, "-fPIC", "-shared"]
    subprocess.run([*words, *map(str, sources), "-o", str(binary), "-lm"], check=True, cwd=folder / "sources")
    with zipfile.ZipFile(plain, "w") as archive:
        for file in (f for f in folder.rglob("*") if f.is_file()):
            archive.write(file, file.relative_to(folder))
    with LoadedFmu(path) as here, LoadedFmu(plain) as there:
        own, other = here.simulate(swing()), there.simulate(swing())
    assert np.ptp(own["joint1.e"]) > 0.01
    np.testing.assert_allclose(own["tip.x"], other["tip.x"], rtol=0, atol=1e-12)
    assert own["joint1.tau"].to_numpy() == pytest.approx(other["joint1.tau"].to_numpy(), abs=1e-8)
