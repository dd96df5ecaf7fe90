"""The FMU's variables: one list for FMI 2.0 and 3.0, in the order of the C enum in runtime/plant/plant.h."""

from collections.abc import Iterator, Mapping
from dataclasses import replace

from flexfmu.law import law_inputs, law_outputs
from flexfmu.names import fmi_name
from flexfmu.variable import Variable
from flexmodels.coordinate import (
    Coordinate,
    feedforward_of,
    motor_of,
    of_joint,
    reference_of,
    start_speed_of,
    switch_of,
    torque_of,
)
from flexmodels.mechanics.plant import Equations
from flexmodels.settings.servo import PER_JOINT, SHARED

STEP = 0.5e-3  # default solver step [s]
SHORTEST = 1e-9  # of a step or a period that must be above zero [s]
SMALLEST = 1e-12  # of a parameter that the equations divide by, in its unit: a minimum may be set
UNLIMITED = 1e30  # of a torque that nothing limits [N m]


def variables(equations: Equations) -> list[Variable]:
    """Every scalar variable of a plant by value reference (runtime/plant/plant.h)."""
    eq = equations
    if eq.servo:
        begin = [
            *_references(eq),
            *_feedforward(eq),
            *_switches(eq),
            *_start_positions(eq),
            *_start_speeds(eq),
        ]
    elif eq.controller:
        begin = [*_references(eq), *_feedforward(eq), *_start_speeds(eq), *_start_errors(eq)]
    else:
        begin = [*_start_positions(eq), *_holding(eq), *_start_speeds(eq)]
    gains = _servo(eq) if eq.servo else _gains(eq)
    step = Variable("solver.step", "parameter", "fixed", "s", "Largest step of the solver", STEP, SHORTEST)
    torques = _held_torques(eq) if eq.drives else _torques(eq)
    received = law_inputs(eq) if eq.drives else []
    return [*begin, *_states(eq), *torques, *_results(eq), *_parameters(eq), *gains, step, *received]


def controller_variables(equations: Equations, integral: Mapping[str, float]) -> list[Variable]:
    """Every variable of the controller alone by value reference (runtime/loop/controller.h)."""
    eq = equations
    return [
        *_references(eq),
        *_feedforward(eq),
        *_measured(eq),
        *_torques(eq),
        *law_outputs(eq),
        *_integrals(eq, integral),
        *_gains(eq),
    ]


def states(equations: Equations) -> tuple[str, ...]:
    """Names of the continuous states: coordinates, then their speeds, then the laws' own states."""
    speeds = (_speed(name) for name in equations.coordinates)
    return (*equations.coordinates, *speeds, *(memory.name for memory in equations.memories))


def nominals(equations: Equations) -> list[float]:
    """Typical sizes of the continuous states."""
    return [v.nominal or 1.0 for v in variables(equations) if v.name in states(equations)]


def _speed(coordinate: str) -> str:
    q = Coordinate.parse(coordinate)
    return of_joint(q.joint, f"d{q.local}")


def _coordinate(eq: Equations, name: str) -> Coordinate:
    q = Coordinate.parse(name)
    return replace(q, unit=_motion_unit(eq, q.joint - 1)) if q.is_motor else q


def _motion_unit(eq: Equations, joint: int) -> str:
    return "m" if eq.prismatic[joint] else "rad"


def _force_unit(eq: Equations, joint: int) -> str:
    return "N" if eq.prismatic[joint] else "N.m"


def _references(eq: Equations) -> Iterator[Variable]:
    for k in range(eq.joints):
        text = f"Reference of joint {k + 1}, read at every sample of the controller"
        yield Variable(reference_of(k + 1), "input", "continuous", _motion_unit(eq, k), text, 0.0)


def _feedforward(eq: Equations) -> Iterator[Variable]:
    for k in range(eq.joints):
        text = f"Feed-forward torque added to the controller's output at joint {k + 1}"
        yield Variable(feedforward_of(k + 1), "input", "continuous", _force_unit(eq, k), text, 0.0)


def _switches(eq: Equations) -> Iterator[Variable]:
    for k in range(1, eq.joints + 1):
        text = f"Servo {k} is on (1) or lets its motor turn freely (0), read at every sample"
        yield Variable(switch_of(k), "input", "continuous", "1", text, 1.0)


def _servo(eq: Equations) -> Iterator[Variable]:
    """In the order of runtime/loop/servo.h."""
    assert eq.servo is not None
    kinds, above = PER_JOINT | SHARED, _positive(eq)
    for name, value in eq.servo.parameters.items():
        unit, text = kinds[name.rpartition(".")[2]]
        yield Variable(name, "parameter", "tunable", unit, text, value, SMALLEST if name in above else 0.0)


def _measured(eq: Equations) -> Iterator[Variable]:
    for k in range(eq.joints):
        text = f"Position of motor hinge {k + 1}, read at every sample of the controller"
        yield Variable(motor_of(k + 1), "input", "continuous", _motion_unit(eq, k), text, 0.0)
    for k in range(eq.joints):
        text = f"Speed of motor hinge {k + 1}, handed on as joint{k + 1}.de_sampled"
        unit = f"{_motion_unit(eq, k)}/s"
        yield Variable(of_joint(k + 1, "de"), "input", "continuous", unit, text, 0.0)


def _start_positions(eq: Equations) -> Iterator[Variable]:
    for k in range(eq.joints):
        text = f"Position of motor hinge {k + 1} at the start, in static equilibrium"
        name = of_joint(k + 1, "e_0")
        yield Variable(name, "parameter", "fixed", _motion_unit(eq, k), text, 0.0)


def _start_speeds(eq: Equations) -> Iterator[Variable]:
    for k in range(eq.joints):
        text = f"Speed of motor hinge {k + 1} at the start"
        name = start_speed_of(k + 1)
        yield Variable(name, "parameter", "fixed", f"{_motion_unit(eq, k)}/s", text, 0.0)


def _start_errors(eq: Equations) -> Iterator[Variable]:
    for k in range(eq.joints):
        text = (
            f"Position of motor hinge {k + 1} at the start, from its first reference, in static equilibrium"
        )
        name = of_joint(k + 1, "start_error")
        yield Variable(name, "parameter", "fixed", _motion_unit(eq, k), text, 0.0)


def _holding(eq: Equations) -> Iterator[Variable]:
    for k in range(eq.joints):
        text = f"Torque that holds joint {k + 1} at the start: the controller's joint{k + 1}.I_0"
        yield Variable(of_joint(k + 1, "tau_0"), "calculatedParameter", "fixed", _force_unit(eq, k), text)


def _integrals(eq: Equations, start: Mapping[str, float]) -> Iterator[Variable]:
    for k in range(eq.joints):
        text = f"Integral of the controller at the start: the torque that holds joint {k + 1} there"
        name = of_joint(k + 1, "I_0")
        yield Variable(name, "parameter", "fixed", _force_unit(eq, k), text, start[name])


def _states(eq: Equations) -> Iterator[Variable]:
    listed = {name: _coordinate(eq, name) for name in eq.coordinates}
    unit = {name: q.unit for name, q in listed.items()}
    for name, q in listed.items():
        small = not q.is_motor
        kind = "deformation of the flexible hinge" if small else "position of the motor hinge"
        text = f"Joint {q.joint}: {kind}"
        nominal = 1e-4 if small else 1.0
        yield Variable(name, "output", "continuous", unit[name], text, nominal=nominal)
    for name, q in listed.items():
        nominal = 1.0 if q.is_motor else 1e-2
        speed = _speed(name)
        kind = "output" if q.is_motor else "local"
        yield Variable(speed, kind, "continuous", f"{unit[name]}/s", f"Speed of {name}", nominal=nominal)
    for memory in eq.memories:
        yield Variable(memory.name, "local", "continuous", memory.unit, memory.description, nominal=1.0)
    for name in eq.coordinates:
        yield Variable(
            f"der({name})",
            "local",
            "continuous",
            f"{unit[name]}/s",
            f"Rate of {name}",
            derivative_of=name,
        )
    for name in eq.coordinates:
        speed = _speed(name)
        text = f"Rate of {speed}"
        yield Variable(f"der({speed})", "local", "continuous", f"{unit[name]}/s2", text, derivative_of=speed)
    for name, unit_of in ((memory.name, memory.unit) for memory in eq.memories):
        rate = f"{unit_of}/s"
        yield Variable(f"der({name})", "local", "continuous", rate, f"Rate of {name}", derivative_of=name)


def _torques(eq: Equations) -> Iterator[Variable]:
    for k in range(1, eq.joints + 1):
        name, unit = torque_of(k), _force_unit(eq, k - 1)
        if eq.controller is None and eq.servo is None:
            yield Variable(name, "input", "continuous", unit, f"Motor torque of joint {k}", 0.0)
            continue
        text = f"Motor torque of joint {k}, held until the next sample"
        yield Variable(name, "output", "discrete", unit, text)


def _held_torques(eq: Equations) -> Iterator[Variable]:
    for k in range(eq.joints):
        text = f"Motor torque of joint {k + 1}, held until the drive receives another law"
        yield Variable(of_joint(k + 1, "tau_motor"), "output", "discrete", _force_unit(eq, k), text)


def _results(eq: Equations) -> Iterator[Variable]:
    for axis in "xyz":
        text = f"Tip position, base axis {axis}"
        yield Variable(f"tip.{axis}", "output", "continuous", "m", text)
    yield from _shown(eq)
    for k in range(eq.joints):
        text = f"Torque that the laws at motor hinge {k + 1} take, the reaction of a stuck hinge included"
        yield Variable(of_joint(k + 1, "friction"), "local", "continuous", _force_unit(eq, k), text)
    for k in range(eq.joints):
        text = (
            f"Event indicator: how far motor hinge {k + 1} is from leaving its friction mode, "
            "a speed while it slides, a torque while it is stuck"
        )
        yield Variable(of_joint(k + 1, "friction_margin"), "local", "continuous", "1", text)
    for name in eq.coordinates:
        unit = _coordinate(eq, name).force_unit
        text = (
            f"Force that the laws take at {name}, motor inertia included, the reaction of a stuck hinge not"
        )
        yield Variable(f"laws.{name}", "local", "continuous", unit, text)


def _shown(eq: Equations) -> Iterator[Variable]:
    """In the order of Equations.shown."""
    for axis in "xyz":
        text = f"Velocity of the tip, base axis {axis}"
        yield Variable(f"tip.velocity.{axis}", "output", "continuous", "m/s", text)
    for part in "xyzw":
        text = f"Orientation of the tip in base axes, quaternion component {part}; (0, 0, 0, 1) at e = 0"
        yield Variable(f"tip.orientation.{part}", "output", "continuous", "1", text)
    for axis in "xyz":
        text = f"Angular velocity of the tip, base axis {axis}"
        yield Variable(f"tip.angular_velocity.{axis}", "output", "continuous", "rad/s", text)
    for word, per in (("position", ""), ("velocity", "/s")):
        for k in range(eq.joints):
            unit = _motion_unit(eq, k) + per
            text = f"Joint {k + 1}: {word} of the link, behind the flexible hinge (motor side and twist)"
            yield Variable(of_joint(k + 1, f"link.{word}"), "output", "continuous", unit, text)


def _positive(eq: Equations) -> frozenset[str]:
    """Parameters that the equations divide by: stiffnesses, and motor inertias behind a flexible hinge."""
    hinges = [Coordinate.parse(name) for name in eq.coordinates[eq.joints :]]
    inertias = {of_joint(hinge.joint, "J_m") for hinge in hinges}
    resistances = {of_joint(k, "servo.R") for k in range(1, eq.joints + 1)}
    return frozenset({str(hinge.stiffness) for hinge in hinges} | inertias | resistances)


def _parameters(eq: Equations) -> Iterator[Variable]:
    above = _positive(eq)
    for name, value in eq.parameters.items():
        minimum = SMALLEST if name in above else 0.0 if name in eq.nonnegative else None
        text = eq.descriptions.get(name, name)
        yield Variable(fmi_name(name), "parameter", "tunable", eq.units[name], text, value, minimum)


def _gains(eq: Equations) -> Iterator[Variable]:
    if eq.controller is None:
        return
    gains = {
        "Kp": ("Proportional", eq.controller.Kp, "N.m/rad", "N/m"),
        "Kd": ("Derivative", eq.controller.Kd, "N.m.s/rad", "N.s/m"),
        "Ki": ("Integral", eq.controller.Ki, "N.m/(rad.s)", "N/(m.s)"),
    }
    for gain, (word, values, hinge, slider) in gains.items():
        for k, value in enumerate(values):
            unit = slider if eq.prismatic[k] else hinge
            text = f"{word} gain of the controller at joint {k + 1}"
            yield Variable(of_joint(k + 1, gain), "parameter", "tunable", unit, text, value)
    for k in range(eq.joints):
        text = f"Largest torque that the controller commands at joint {k + 1}, either way"
        name = of_joint(k + 1, "tau_max")
        yield Variable(name, "parameter", "tunable", _force_unit(eq, k), text, UNLIMITED, 0.0)
    text = "Time between two samples of the controller"
    yield Variable("controller.period", "parameter", "fixed", "s", text, eq.controller.period, SHORTEST)
