"""Pinocchio's regressor over all samples: in Python (our loop, figaroh's), and in C++ where that builds."""

import shutil
import subprocess
import tempfile
from importlib.util import find_spec
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pinocchio as pin  # pyright: ignore[reportMissingImports]
from benchmarks.measure import best

_SOURCE = r"""
#include <pinocchio/multibody.hpp>
#include <pinocchio/algorithm/regressor.hpp>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <vector>
using namespace pinocchio;
int main(int, char** files)
{
    std::ifstream in(files[1]);
    int joints, samples;
    in >> joints >> samples;
    Model model;
    for (int i = 0; i < joints; i++) {
        SE3 place; Vector3 axis; double x;
        for (int k = 0; k < 9; k++) { in >> x; place.rotation()(k / 3, k % 3) = x; }
        for (int k = 0; k < 3; k++) { in >> x; place.translation()[k] = x; }
        for (int k = 0; k < 3; k++) { in >> x; axis[k] = x; }
        model.addJoint(i, JointModelRevoluteUnaligned(axis), place, "j" + std::to_string(i));
    }
    Data data(model);
    Eigen::MatrixXd m(3 * model.nv, samples);
    for (int s = 0; s < samples; s++) for (int k = 0; k < m.rows(); k++) in >> m(k, s);
    Eigen::MatrixXd store(model.nv, 10 * model.nv * 100);
    double least = 1e9;
    for (int round = 0; round < 3; round++) {
        auto begin = std::chrono::steady_clock::now();
        for (int s = 0; s < samples; s++)
            store.middleCols(10 * model.nv * (s % 100), 10 * model.nv) = computeJointTorqueRegressor(
                model, data, m.col(s).head(model.nv), m.col(s).segment(model.nv, model.nv),
                m.col(s).tail(model.nv));
        std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
        least = std::min(least, took.count());
    }
    std::printf("%g\n", samples / least);
}
"""
_BOOST = [
    "-DBOOST_FUSION_INVOKE_MAX_ARITY=10",
    "-DBOOST_MPL_LIMIT_LIST_SIZE=30",
    "-DBOOST_MPL_CFG_NO_PREPROCESSED_HEADERS",
]
_VECTOR3 = "typedef Eigen::Vector3d Vector3;\n"


def python_speed(model, motion: tuple[np.ndarray, ...]) -> float:
    """Samples per second of the loop in Python, every regressor stored."""
    data, samples = model.createData(), len(motion[0])
    store = np.zeros((samples, model.nv, 10 * model.nv))

    def loop() -> None:
        for s, (q, dq, ddq) in enumerate(zip(*motion, strict=True)):
            store[s] = pin.computeJointTorqueRegressor(model, data, q, dq, ddq)

    return samples / best(loop)


def figaroh_speed(model, motion: tuple[np.ndarray, ...]) -> float:
    """Samples per second of figaroh's stacked regressor, inertial columns alone; a loop in Python too."""
    from figaroh.tools.regressor import build_regressor_basic  # pyright: ignore[reportMissingImports]

    robot = SimpleNamespace(model=model, data=model.createData())
    plan = {"is_joint_torques": True, "act_idxv": range(model.nv)}
    return len(motion[0]) / best(lambda: build_regressor_basic(robot, *motion, plan))


def cpp_speed(model, motion: tuple[np.ndarray, ...]) -> float | str:
    """Samples per second of the loop in C++, or why it could not be built."""
    if shutil.which("g++") is None:
        return "there is no g++"
    spec = find_spec("pinocchio")
    assert spec is not None
    assert spec.origin is not None
    prefix = Path(spec.origin).parents[4]
    if not (prefix / "include/eigen3").is_dir():
        return "Eigen's headers are missing; pip install cmeel-eigen"
    with tempfile.TemporaryDirectory() as folder:
        source, binary, data = (Path(folder) / name for name in ("loop.cpp", "loop", "data.txt"))
        source.write_text(_SOURCE.replace("int main", _VECTOR3 + "int main"))
        data.write_text(_as_text(model, motion))
        command = [
            "g++",
            "-std=c++17",
            "-O3",
            "-march=native",
            "-DNDEBUG",
            *_BOOST,
            str(source),
            "-o",
            str(binary),
        ]
        command += [f"-I{prefix}/include", f"-I{prefix}/include/eigen3", f"-L{prefix}/lib"]
        command += ["-lpinocchio_default", f"-Wl,-rpath,{prefix}/lib"]
        built = subprocess.run(command, capture_output=True, text=True)
        if built.returncode:
            errors = [line for line in built.stderr.splitlines() if "error" in line]
            return f"g++ failed: {(errors or ['no reason given'])[0]}"
        return float(subprocess.run([binary, data], capture_output=True, text=True, check=True).stdout)


def _as_text(model, motion: tuple[np.ndarray, ...]) -> str:
    """A chain of turns: per joint placement and axis; then q, dq, ddq per sample."""
    lines = [f"{model.nv} {len(motion[0])}"]
    for joint, place in zip(list(model.joints)[1:], list(model.jointPlacements)[1:], strict=True):
        axis = joint.createData()
        joint.calc(axis, np.zeros(model.nq))
        numbers = (*place.rotation.ravel(), *place.translation, *np.asarray(axis.S).ravel()[3:])
        lines.append(" ".join(repr(float(x)) for x in numbers))
    lines += [" ".join(f"{x:.8g}" for x in np.concatenate(rates)) for rates in zip(*motion, strict=True)]
    return "\n".join(lines)
