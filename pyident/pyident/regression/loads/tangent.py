"""Friction under the load of rigid joints, linear in the bodies that make the load.

The load is L p, linear in the bodies, and its friction μ f(L p), which is no longer linear in μ and p
together. About values (μ₀, p₀) it is μ f + μ₀ f' L (p − p₀). The part with p belongs to the bodies' columns
of Φ, and what is left is known: where f is of degree d in the load, d μ₀ times the column of μ.

Without that part rounds of linear estimates settle where the load is that of the values found, which is not
where the equations are fitted best; and what only friction tells, the share of a rotor in the inertia about
the first axis, stays open.
"""

from functools import cache

import numpy as np
import sympy

from flexmodels.effects import signals
from flexmodels.effects.effect import Effect
from flexmodels.joint import parameter_name
from flexmodels.robot import Robot
from pyident.regression.loads.bodies import body_laws, link_names, per_load


class LoadTangent:
    """What the equations of a robot's logs get about its own values.

    shift   (P,) what y gets, in columns of Φ: y + Φ shift = Φ' p
    """

    def __init__(self, robot: Robot):
        names = list(robot.linear_parameters)
        values = np.array(list(robot.linear_parameters.values()), float)
        self.shift = np.zeros(len(names))
        self.acting: dict[int, list[int]] = {}  # row -> columns of its laws
        for k, joint in robot.numbered:
            for law in joint.effects:
                if joint.flexible or signals.load not in law.symbols:
                    continue
                for parameter in law.linear:
                    column = names.index(parameter_name(k, law.name, parameter.name))
                    self.shift[column] = degree_in_load(law) * values[column]
                    self.acting.setdefault(k - 1, []).append(column)
        bodies = link_names(robot) + [name for name, _ in body_laws(robot)]
        self.bodies = np.array([names.index(name) for name in bodies])

    def take(self, Phi: np.ndarray, y: np.ndarray, loads: np.ndarray) -> None:
        """Change equations Φ (B, n, P), y (B, n), in place; loads (B, joints), as of `carried_loads`."""
        for row, columns in self.acting.items():
            friction = Phi[:, row, columns] @ self.shift[columns]
            y[:, row] += friction
            Phi[:, row, self.bodies] *= 1 + per_load(friction, loads[:, row])[:, None]


@cache
def degree_in_load(law: Effect) -> float:
    """Of a law's force in the load."""
    (force,) = law.forces.values()
    twice = sympy.Abs(force.subs(signals.load, 2 * signals.load) / force)
    return float(sympy.log(sympy.simplify(twice), 2))
