"""The declared model structure and the derivatives against changes of every known, in every mode."""

import numpy as np
import pytest
from fmu_modes import MODES, Moving, declared_in


@pytest.mark.parametrize("fmi", [2, 3])
@pytest.mark.parametrize("mode", MODES)
def test_no_dependency_is_left_out(fmus, mode, fmi):
    """FMI 2.0.5 and 3.0.2: the derivative by a known that is not listed is zero, at any time."""
    fmu = Moving(fmus[fmi], mode)
    declared = declared_in(fmu)
    assert len(declared) > 60
    still = fmu.values({})
    missing = []
    for known in fmu.at:
        moved = np.zeros(len(still), dtype=bool)
        for sign in (1, -1):
            h = sign * fmu.step_of(known)
            if fmu.at[known] + h < 0 and not known.startswith("joint") and known not in fmu.states:
                continue
            moved |= fmu.values({known: h}) != still
        missing += [
            (name, known)
            for name, changed in zip(fmu.unknown, moved, strict=True)
            if changed and name in declared and known not in declared[name] and known != name
        ]
    assert not missing


@pytest.mark.parametrize("fmi", [2, 3])
def test_the_structure_is_no_longer_than_it_must_be(fmus, fmi):
    """The tip follows the coordinates alone, and the rate of a coordinate its speed."""
    fmu = Moving(fmus[fmi], "continuous")
    declared = declared_in(fmu)
    assert declared["der(joint1.eps[2])"] == {"joint1.deps[2]"}
    assert declared["tip.x"] <= {name for name in fmu.states if ".e" in name}
    assert "link2.m" in declared["der(joint3.de)"]
    assert {"joint1.r", "joint1.tau_ff", "joint1.Kp"} <= declared["der(joint1.de)"]
    assert declared["joint1.tau"] == {
        f"joint1.{s}" for s in ("r", "tau_ff", "e", "Kp", "Kd", "Ki", "tau_max")
    }


@pytest.mark.parametrize("fmi", [2, 3])
def test_every_unknown_that_moves_is_declared(fmus, fmi):
    """Outputs, rates of all states and, at the start, the states too; nothing else, and none twice."""
    running, first = (declared_in(Moving(fmus[fmi], mode)) for mode in ("continuous", "initialisation"))
    fmu = Moving(fmus[fmi], "continuous")
    outputs = {v.name for v in fmu.description.modelVariables if v.causality == "output"}
    rates = {f"der({name})" for name in fmu.states}
    margins = {f"joint{k}.friction_margin" for k in range(1, 5)} if fmi == 3 else set()
    assert set(running) == outputs | rates | margins
    assert set(first) == outputs | rates | set(fmu.states)


@pytest.mark.parametrize("fmi", [2, 3])
@pytest.mark.parametrize("mode", MODES)
def test_directional_derivatives_are_right_in_every_mode(fmus, mode, fmi):
    """All knowns move at once, along random directions; friction, margins and laws are among the unknowns."""
    fmu = Moving(fmus[fmi], mode)
    known = [name for name in fmu.at if not name.endswith(("tau_max", "joint4.de_0"))]  # no derivative there
    unknown = [name for name in fmu.unknown if name not in known]
    places = [fmu.unknown.index(name) for name in unknown]
    rng = np.random.default_rng(0)
    for _ in range(4):
        seed = {name: fmu.step_of(name) * rng.normal() for name in known}
        exact = fmu.fmu.getDirectionalDerivative(
            [fmu.vr[n] for n in unknown], [fmu.vr[n] for n in known], list(seed.values())
        )
        ahead, behind = (fmu.values({n: s * v for n, v in seed.items()}) for s in (1, -1))
        differences = (ahead - behind)[places] / 2
        size = np.abs(fmu.values({})[places])
        np.testing.assert_allclose(exact, differences, rtol=2e-4, atol=1e-9 * (1 + size.max()))
        assert np.count_nonzero(exact) > 0.7 * len(unknown)
