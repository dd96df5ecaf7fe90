"""Robot -> Modelica 3.6: components with the paper's names in one package, readable by a person.

The components (templates/components.mo) are Newton's and Euler's equations in base axes, written for this and
derived apart from the recursions of flexmodels.mechanics: that both move alike is a test.
"""

from collections.abc import Sequence
from importlib import resources
from pathlib import Path

import numpy as np

from flexfmu.names import c_identifier
from flexmodels.atomic import replacing
from flexmodels.compiling.compiler import BuildError
from flexmodels.effects import BASE
from flexmodels.joint import Joint
from flexmodels.link import LINK_PARAMETERS
from flexmodels.mechanics.plant import equations
from flexmodels.robot import Robot

_ROUNDS = 50  # of Newton's method for the static equilibrium
_STILL = 1e-9  # of the largest moment
# Words that name nothing of one's own in Modelica 3.6, section 2.3.3, and the types that every class knows.
_RESERVED = """
algorithm and annotation assert block break class connect connector constant constrainedby der discrete each
else elseif elsewhen encapsulated end enumeration equation expandable extends external false final flow for
function if import impure in initial inner input loop model not operator or outer output package parameter
partial protected public pure record redeclare replaceable return stream then true type when while within
Real Integer Boolean String time
"""


def export_modelica(robot: Robot, path: str | Path) -> Path:
    """Write the package. Raises BuildError for what the components do not describe."""
    path, text = Path(path), modelica_text(robot)
    with replacing(path) as file:
        file.write_text(text, encoding="utf-8")
    return path


def modelica_text(robot: Robot) -> str:
    """A package with the components, the model `Arm` (references and added torques in) and `Run` of it.

    `Run` swings every joint smoothly out of its start, which is the static equilibrium at e = 0.
    """
    _require(robot)
    components = (resources.files("flexfmu") / "templates" / "components.mo").read_text(encoding="utf-8")
    bent, holding = _equilibrium(robot)
    name = _package_name(robot)
    head = f'package {name} "{_quoted(robot.description or robot.name)}"\n'
    parts = [head, components.rstrip("\n"), "", _arm(robot, bent, holding), "", _run(robot), f"end {name};"]
    return "\n".join(parts) + "\n"


def _package_name(robot: Robot) -> str:
    name = c_identifier(robot.name)
    return f"{name}_robot" if name in _RESERVED.split() else name


def _require(robot: Robot) -> None:
    if robot.controller is None:
        raise BuildError(f"robot {robot.name} has no [controller]; its Modelica text needs one")
    if robot.passive:
        raise BuildError(
            f"robot {robot.name} has a closed linkage, which the Modelica text does not describe"
        )
    for k, joint in robot.numbered:
        if joint.kind != "revolute":
            raise BuildError(f"joint {k} of {robot.name} slides; the Modelica text describes turning joints")
        others = sorted(set(joint.values) - set(BASE))
        if others:
            raise BuildError(
                f"joint {k} of {robot.name} has {others[0]}, which the Modelica text does not have"
            )


def _equilibrium(robot: Robot) -> tuple[dict[str, float], list[float]]:
    """Deformations at rest at e = 0, and the torques that hold the arm there."""
    eq = equations(robot)
    x, p = np.zeros(eq.balance.size1_in(0)), np.array(list(eq.parameters.values()))
    n, joints = len(eq.coordinates), eq.joints
    slope = eq.balance.jacobian()
    for _ in range(_ROUNDS):
        force = np.array(eq.balance(x, p)).ravel()
        if n == joints or np.abs(force[joints:]).max() < _STILL * max(np.abs(force).max(), 1.0):
            break
        J = np.array(slope(x, p, force)[0])[joints:, joints:n]
        x[joints:n] -= np.linalg.solve(J, force[joints:])
    else:
        raise BuildError(
            f"robot {robot.name}: no rest was found at zero angles; check its stiffness and masses"
        )
    bent = dict(zip(eq.coordinates[joints:], x[joints:n].tolist(), strict=True))
    return bent, np.array(eq.balance(x, p)).ravel()[:joints].tolist()


def _arm(robot: Robot, bent: dict[str, float], holding: Sequence[float]) -> str:
    n = len(robot.joints)
    lines = [
        '  model Arm "The arm with its controller"',
        f'    input Real r[{n}] "References";',
        f'    input Real tau_ff[{n}] "Torques added to the controller\'s";',
        f"    Base base(gravity={_vector(robot.gravity)});",
    ]
    for k, joint in robot.numbered:
        lines += [f"    {line}" for line in _components(robot, k, joint, bent, holding[k - 1])]
    lines += ['    Position tip[3] "In base axes";', "  equation"]
    standing = [k for k, _ in robot.numbered if robot.parents[k - 1] == 0]
    for letter in "ft":
        lines.append(f"    base.out.{letter} = {' + '.join(f'joint{k}.inn.{letter}' for k in standing)};")
    for k, _ in robot.numbered:
        lines += [f"    {line}" for line in _connections(robot, k)]
    tip = f"link{robot.last_link}.tip" if robot.last_link else _vector(robot.tip)
    return "\n".join([*lines, f"    tip = {tip};", "  end Arm;"])


def _components(robot: Robot, k: int, joint: Joint, bent: dict[str, float], holding: float) -> list[str]:
    p, c, link = robot.parameters, robot.controller, robot.links[k - 1].values
    assert c is not None
    friction = ", ".join(
        f"{name}={_number(p.get(f'joint{k}.{name}', 0.0))}" for name in ("coulomb", "viscous", "offset")
    )
    lines = [
        f"MotorHinge joint{k}(x={_vector(joint.triad[:, 0])}, origin={_vector(joint.origin)}, "
        f"J_m={_number(p[f'joint{k}.J_m'])},",
        f"  {friction});",
    ]
    if joint.flexible:
        start = [bent.get(f"joint{k}.eps[{i}]", 0.0) for i in (1, 2, 3)]
        k_d = [[p.get(f"joint{k}.{s}[{i}]", 0.0) for i in joint.deformations] for s in ("k", "d")]
        if joint.bends:
            triad = "{" + ", ".join(_vector(row) for row in joint.triad) + "}"
            lines += [
                f"FlexibleHinge hinge{k}(triad={triad},",
                f"  k={_vector(k_d[0])}, d={_vector(k_d[1])}, eps_start={_vector(start)});",
            ]
        else:
            values = f"k={_number(k_d[0][0])}, d={_number(k_d[1][0])}, eps_start={_number(start[0])}"
            lines.append(f"TwistHinge hinge{k}(x={_vector(joint.triad[:, 0])}, {values});")
    J = [[link[f"J[{min(a, b)}{max(a, b)}]"] for b in "xyz"] for a in "xyz"]
    ms = _vector([link[f"ms[{a}]"] for a in "xyz"])
    assert set(link) == set(LINK_PARAMETERS)
    reach = robot.tip if k == robot.last_link else _reach(robot, k)
    inertia = "{" + ", ".join(_vector(row) for row in J) + "}"
    lines += [f"Link link{k}(m={_number(link['m'])}, ms={ms}, reach={_vector(reach)},", f"  J={inertia});"]
    gains = ", ".join(f"{g}={_number(getattr(c, g)[k - 1])}" for g in ("Kp", "Kd", "Ki"))
    lines.append(
        f"Pid controller{k}(period={_number(c.period)}, {gains}, integral_start={_number(holding)});"
    )
    return lines


def _connections(robot: Robot, k: int) -> list[str]:
    """A body's needs are its own and those of every joint that sits on it."""
    joint, parent = robot.joints[k - 1], robot.parents[k - 1]
    begin = f"{_end(robot, parent)}.out" if parent else "base.out"
    children = [j for j, _ in robot.numbered if robot.parents[j - 1] == k]
    lines = _seen(begin, f"joint{k}.inn")
    if joint.flexible:
        lines.append(f"connect(joint{k}.out, hinge{k}.inn);")
    end = f"{_end(robot, k)}.out"
    lines += _seen(end, f"link{k}.inn")
    for letter in "ft":
        needs = " + ".join([f"link{k}.inn.{letter}", *(f"joint{j}.inn.{letter}" for j in children)])
        lines.append(f"{end}.{letter} = {needs};")
    lines += [f"controller{k}.r = r[{k}];", f"controller{k}.tau_ff = tau_ff[{k}];"]
    lines += [f"controller{k}.e = joint{k}.e;", f"joint{k}.tau = controller{k}.tau;"]
    return lines


def _seen(outer: str, inner: str) -> list[str]:
    return [f"{inner}.{v} = {outer}.{v};" for v in ("r", "A", "omega", "a", "alpha")]


def _end(robot: Robot, k: int) -> str:
    """The component that carries link k."""
    return f"hinge{k}" if robot.joints[k - 1].flexible else f"joint{k}"


def _reach(robot: Robot, k: int) -> Sequence[float]:
    """Where the next joint sits."""
    following = [joint.origin for j, joint in robot.numbered if robot.parents[j - 1] == k]
    return following[0] if following else (0.0, 0.0, 0.0)


def _run(robot: Robot) -> str:
    n = len(robot.joints)
    swing = _vector([0.2 / (1 + k) for k in range(n)])
    lines = [
        '  model Run "The arm swings out and back"',
        f'    parameter Real swing[{n}] = {swing} "[rad]";',
        '    parameter Real frequency = 0.5 "[Hz]";',
        "    Arm arm;",
        "  equation",
        *(
            f"    arm.r[{k}] = swing[{k}]*(1 - cos(6.283185307179586*frequency*time))/2;"
            for k in range(1, n + 1)
        ),
        *(f"    arm.tau_ff[{k}] = 0;" for k in range(1, n + 1)),
        "    annotation(experiment(StopTime=2, Tolerance=1e-10));",
        "  end Run;",
    ]
    return "\n".join(lines)


def _vector(values) -> str:
    return "{" + ", ".join(_number(v) for v in values) + "}"


def _number(value: float) -> str:
    return repr(float(value))


def _quoted(text: str) -> str:
    """Inside a string; a backslash at its end would leave it in parsers that do not know `\\\\`."""
    return text.replace("\\", "/").replace('"', '\\"')
