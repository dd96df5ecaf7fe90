"""CasADi's FMU importer: the model as functions of its states, with the FMU's own derivatives.

CasADi ("Next event time not implemented") cannot simulate a sampled controller, so it evaluates instead: the
outputs at the states of a log, and the Jacobians there beside central differences.
"""

import casadi as ca
import numpy as np
from request import read, write

SHIFT = 1e-6


def main() -> None:
    request = read()
    model = ca.DaeBuilder("plant", request.fmu, {})
    names, shown = model.x(), model.y()
    plant = model.create("plant", ["x", "u"], ["ode", "y"])
    jacobian = plant.factory("jacobian", ["x", "u"], ["jac:ode:x", "jac:y:x"])
    weighted = plant.factory("weighted", ["x", "u", "adj:ode", "adj:y"], ["adj:x"])
    u = [values[0] for values in request.inputs.values()]
    log = np.zeros((len(request.time), len(names)))  # at rest
    for name, values in request.states.items():
        log[:, names.index(name)] = values
    rows = np.array([np.array(plant(x, u)[1]).ravel() for x in log[1:]])
    x = log[-1]
    forward = np.vstack([np.array(j) for j in jacobian(x, u)])
    sides = [[ca.vertcat(*plant(x + s, u)) for s in (h, -h)] for h in SHIFT * np.eye(len(x))]
    difference = np.hstack([np.array(up - down) / (2 * SHIFT) for up, down in sides])
    weights = np.random.default_rng(0).normal(size=len(forward))
    adjoint = np.array(weighted(x, u, weights[: len(x)], weights[len(x) :])).ravel()
    write(
        {name: rows[:, shown.index(name)].tolist() for name in request.outputs}
        | {"jacobian": forward.tolist(), "differences": difference.tolist()}
        | {"adjoint": adjoint.tolist(), "adjoint expected": (forward.T @ weights).tolist()}
    )


main()
