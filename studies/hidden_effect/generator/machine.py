"""An arm as compiled code: its static equilibrium, and fourth-order Runge-Kutta steps under given torques."""

import ctypes
import hashlib
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import casadi as ca
import numpy as np

from . import model
from .model import Arm

_DRIVER = """
void advance(double t, double h, int steps, double *x, const double *u, const double *p) {
  double k[4][NX], y[NX], w[SZ_W + 1]; casadi_int iw[SZ_IW + 1];
  const double *arg[SZ_ARG + 4]; double *res[SZ_RES + 1];
  const double at[4] = {0, 0.5, 0.5, 1};
  for (int n = 0; n < steps; n++) {
    for (int s = 0; s < 4; s++) {
      double now = t + (n + at[s]) * h;
      for (int i = 0; i < NX; i++) y[i] = x[i] + (s ? at[s] * h * k[s - 1][i] : 0);
      arg[0] = y; arg[1] = u + n * NU; arg[2] = &now; arg[3] = p; res[0] = k[s];
      rates(arg, res, iw, w, 0);
    }
    for (int i = 0; i < NX; i++) x[i] += h / 6 * (k[0][i] + 2 * k[1][i] + 2 * k[2][i] + k[3][i]);
  }
}
"""


class Machine:
    """An arm as compiled code."""

    def __init__(self, arm: Arm):
        self.arm, n = arm, len(arm.names)
        self.size = 2 * n + len(arm.states)
        x = ca.vertcat(arm.q, arm.v, *arm.states)
        rates = ca.Function("rates", [x, arm.u, arm.t, arm.p], [ca.cse(model.rates(arm))])
        self._advance = _compiled(rates, self.size, arm.joints)
        self.tip = ca.Function("tip", [x, arm.p], [model.tip(arm)])
        self.hidden = ca.Function("hidden", [x, arm.u, arm.t, arm.p], [arm.hidden])
        free = [*range(arm.joints, n)]
        at_rest = ca.substitute(
            model.force(arm), ca.vertcat(arm.v, *arm.states, arm.t), ca.SX.zeros(n + len(arm.states) + 1)
        )
        unknown = ca.vertcat(arm.u, arm.q[free])
        self._rest = ca.Function(
            "rest", [unknown, arm.q[: arm.joints], arm.p], [at_rest, ca.jacobian(at_rest, unknown)]
        )

    def equilibrium(self, e: np.ndarray, p: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """State at rest at motor angles e, and the motor torques that hold it there."""
        unknown = np.zeros(len(self.arm.names))
        for _ in range(200):
            f, J = (np.array(value) for value in self._rest(unknown, e, p))
            step = np.linalg.solve(J, f.ravel())
            largest = np.abs(step[self.arm.joints :]).max(initial=0)
            unknown -= step * min(1.0, 2e-3 / max(largest, 1e-300))
            if np.abs(f).max() < 1e-8:
                break
        else:
            raise RuntimeError(f"no equilibrium at {e}: {np.abs(f).max():.3g} N m are left")
        x = np.zeros(self.size)
        x[: self.arm.joints] = e
        x[self.arm.joints : len(self.arm.names)] = unknown[self.arm.joints :]
        return x, unknown[: self.arm.joints]

    def advance(self, t: float, h: float, x: np.ndarray, u: np.ndarray, p: np.ndarray) -> None:
        """Advance x in place by len(u) steps of h under torques u (steps, joints)."""
        d = ctypes.POINTER(ctypes.c_double)
        self._advance(
            ctypes.c_double(t), ctypes.c_double(h), len(u), *(a.ctypes.data_as(d) for a in (x, u, p))
        )


def _compiled(rates: ca.Function, states: int, inputs: int):
    """The C function `advance` of these rates; compiled once per program text."""
    generator = ca.CodeGenerator("rates", {"with_header": False})
    generator.add(rates)
    sizes = {"NX": states, "NU": inputs}
    sizes |= {f"SZ_{n.upper()}": getattr(rates, f"sz_{n}")() for n in ("w", "iw", "arg", "res")}
    defines = "".join(f"#define {name} {value}\n" for name, value in sizes.items())
    text = generator.dump() + defines + _DRIVER
    folder = Path(tempfile.gettempdir()) / f"hidden_effect_{os.getuid() if hasattr(os, 'getuid') else 0}"
    folder.mkdir(mode=0o700, exist_ok=True)
    library = folder / f"{hashlib.sha256(text.encode()).hexdigest()[:24]}.so"
    if not library.exists():
        with tempfile.TemporaryDirectory(dir=folder) as place:
            source, made = Path(place) / "arm.c", Path(place) / "arm.so"
            source.write_text(text)
            command = [*_compiler(), "-O2", "-shared", "-fPIC", "-o", str(made), str(source), "-lm"]
            subprocess.run(command, check=True, capture_output=True)
            made.replace(library)
    advance = ctypes.CDLL(str(library)).advance
    advance.restype = None
    return advance


def _compiler() -> list[str]:
    found = next((c for c in ("cc", "gcc", "clang") if shutil.which(c)), None)
    return [found] if found else [sys.executable, "-m", "ziglang", "cc"]
