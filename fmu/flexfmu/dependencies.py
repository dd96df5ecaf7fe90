"""What depends on what: the model structure, from the sparsity of the equations.

The standard reads an unlisted known as a derivative that is zero in every mode, so what an event does counts:
a torque answers to the inputs of its sample, and the rates to that torque.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import casadi as ca

from flexfmu.code.generated import everything
from flexfmu.law import SAMPLED, law_names
from flexfmu.names import fmi_name
from flexfmu.variables import states
from flexmodels.mechanics.plant import Equations

_GAINS = ("Kp", "Kd", "Ki", "tau_max")
Known = frozenset[str]


@dataclass(frozen=True)
class Dependencies:
    """Unknown -> the knowns that it depends on: while the FMU runs, and in initialisation."""

    running: Mapping[str, Known]
    initial: Mapping[str, Known]


def controller_dependencies(joints: int) -> Dependencies:
    """Of a controller alone: a sample that is due answers at once."""
    running: dict[str, Known] = {SAMPLED: frozenset()}
    initial: dict[str, Known] = {SAMPLED: frozenset()}
    for k in range(1, joints + 1):
        own = {f"joint{k}.{s}" for s in ("r", "tau_ff", "e", *_GAINS)}
        running |= dict.fromkeys((f"joint{k}.{s}" for s in ("tau", "stiffness", "damping")), frozenset(own))
        first = {f"joint{k}.{s}" for s in ("r", "tau_ff", "e", "Kp", "tau_max", "I_0")}
        initial |= dict.fromkeys((f"joint{k}.{s}" for s in ("tau", "stiffness", "damping")), frozenset(first))
        initial[f"joint{k}.damping"] |= {f"joint{k}.Kd"}
        for seen in ("e", "de"):
            running[f"joint{k}.{seen}_sampled"] = frozenset([f"joint{k}.{seen}"])
            initial[f"joint{k}.{seen}_sampled"] = frozenset([f"joint{k}.{seen}"])
        running[f"joint{k}.tau_rate"] = frozenset(own)
        initial[f"joint{k}.tau_rate"] = frozenset()  # it needs two samples
    return Dependencies(running, initial)


def plant_dependencies(equations: Equations) -> Dependencies:
    """Of an arm, with its controller or with its torques as inputs."""
    eq, x = equations, states(equations)
    itself = {name: frozenset([name]) for name in x}
    return Dependencies(
        running=_following(eq, itself, _torque(eq)) | itself,
        initial=_at_start(eq),
    )


def _torque(eq: Equations) -> list[Known]:
    """Knowns of every joint's torque, a state among them."""
    joints = range(1, eq.joints + 1)
    if eq.servo is not None:
        return [_servo_inputs(eq, k) | {f"joint{k}.e", f"joint{k}.de"} for k in joints]
    if eq.drives:
        return [frozenset(law_names(k)) | {SAMPLED, f"joint{k}.e", f"joint{k}.de"} for k in joints]
    if eq.controller is None:
        return [frozenset([f"joint{k}.tau"]) for k in joints]
    return [frozenset(f"joint{k}.{s}" for s in ("r", "tau_ff", "e", *_GAINS)) for k in joints]


def _following(eq: Equations, state: Mapping[str, Known], torque: Sequence[Known]) -> dict[str, Known]:
    """Torques, rates, results, when the knowns of states and torques are given."""
    x = states(eq)
    function = everything(eq)
    names = [
        *(f"der({name})" for name in x),
        *(None for _ in range(eq.joints)),  # imbalance
        *(f"joint{k}.friction" for k in range(1, eq.joints + 1)),
        *(None for _ in range(2 * eq.joints)),  # breakaway
        *(f"laws.{name}" for name in eq.coordinates),
        *(f"tip.{axis}" for axis in "xyz"),
        *shown_names(eq.joints),
    ]
    rows = _rows(function, [state[name] for name in x], torque, _parameters(eq))
    out = {name: row for name, row in zip(names, rows, strict=True) if name}
    n, joints = len(x), eq.joints
    for k in range(joints):
        braking, sliding = rows[n + k], rows[n + joints + k]
        levels = rows[n + 2 * joints + k] | rows[n + 3 * joints + k]
        speed = state[f"joint{k + 1}.de"]
        out[f"joint{k + 1}.friction"] = braking | sliding
        out[f"joint{k + 1}.friction_margin"] = braking | levels | speed
        if eq.controller or eq.servo:
            out[f"joint{k + 1}.tau"] = torque[k]
        if eq.drives:
            out[f"joint{k + 1}.tau_motor"] = torque[k]
    return out


def _at_start(eq: Equations) -> dict[str, Known]:
    """Through the static equilibrium."""
    x, n, joints = states(eq), len(eq.coordinates), range(1, eq.joints + 1)
    begin = ("r", "start_error") if eq.controller else ("e_0",)
    motors = [frozenset(f"joint{k}.{s}" for s in begin) for k in joints]
    none: Known = frozenset()
    parameters = _parameters(eq)
    still = [*motors, *[none] * (len(x) - eq.joints)]
    force = _rows(eq.balance, still, None, parameters)
    bent = frozenset().union(*force[eq.joints :]) if n > eq.joints else none
    still[eq.joints : n] = [bent] * (n - eq.joints)
    force = _rows(eq.balance, still, None, parameters)
    speeds = [frozenset([f"joint{k}.de_0"]) for k in joints]
    still[n : n + eq.joints] = speeds
    memories = _rows(eq.start, still, force[: eq.joints], parameters)
    state = dict(zip(x, [*still[: 2 * n], *memories], strict=True))
    torque = _first_torque(eq, force)
    out = state | _following(eq, state, torque)
    if eq.controller is None and eq.servo is None:
        out |= {f"joint{k}.tau_0": force[k - 1] for k in joints}
    return out


def _servo_inputs(eq: Equations, joint: int) -> Known:
    assert eq.servo is not None
    others = tuple(f"joint{k}." for k in range(1, eq.joints + 1) if k != joint)
    own = {fmi_name(name) for name in eq.servo.parameters if not name.startswith(others)}
    return frozenset(own | {f"joint{joint}.{s}" for s in ("r", "tau_ff", "on")})


def _first_torque(eq: Equations, force: Sequence[Known]) -> list[Known]:
    if eq.servo is not None:
        joints = range(1, eq.joints + 1)
        return [_servo_inputs(eq, k) | {f"joint{k}.e_0", f"joint{k}.de_0"} for k in joints]
    if eq.drives:
        starts = ({f"joint{k}.e_0", f"joint{k}.de_0"} for k in range(1, eq.joints + 1))
        return [frozenset(law_names(k)) | {SAMPLED} | start for k, start in enumerate(starts, start=1)]
    if eq.controller is None:
        return _torque(eq)
    own = ("start_error", "tau_ff", "Kp", "tau_max")
    return [force[k - 1] | {f"joint{k}.{s}" for s in own} for k in range(1, eq.joints + 1)]


def _parameters(eq: Equations) -> list[Known]:
    return [frozenset([fmi_name(name)]) for name in eq.parameters]


def _rows(
    function: ca.Function, x: Sequence[Known], u: Sequence[Known] | None, p: Sequence[Known]
) -> list[Known]:
    """Knowns of every element of the first output, from those of (x, u, p) or (x, p)."""
    columns = [x, p] if u is None else [x, u, p]
    rows: list[set[str]] = [set() for _ in range(function.numel_out(0))]
    for i, knowns in enumerate(columns):
        pattern = function.jac_sparsity(0, i)
        for row, column in zip(*pattern.get_triplet(), strict=True):
            rows[row] |= knowns[column]
    return [frozenset(row) for row in rows]


def shown_names(joints: int) -> list[str]:
    """Names of Equations.shown."""
    tip = [*(f"velocity.{a}" for a in "xyz"), *(f"orientation.{a}" for a in "xyzw")]
    tip += [f"angular_velocity.{a}" for a in "xyz"]
    links = [f"joint{k}.link.{word}" for word in ("position", "velocity") for k in range(1, joints + 1)]
    return [*(f"tip.{name}" for name in tip), *links]
