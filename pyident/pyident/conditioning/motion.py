"""What the regression knows of a motion."""

from dataclasses import dataclass

import numpy as np

from flexmodels.robot import Robot


@dataclass(frozen=True)
class Motion:
    """A measured motion over N samples, SI units, columns in the order of `robot.coordinates`.

    q, dq, ddq    N x n
    tau           N x joints, motor torques [N m or N]: at the sample, or held from the sample on
    time          N [s]
    tau_before    N x joints, torques held until the sample; None: torques are not held. With it q, dq and ddq
                  are means under the sample's hat function (conditioning.weak_form), and so are the columns
    needed        N x joints, torques that a fitted model needs along it; None: nobody has fitted one
    tau and time are needed only where a law uses them.
    """

    q: np.ndarray
    dq: np.ndarray
    ddq: np.ndarray
    tau: np.ndarray | None = None
    time: np.ndarray | None = None
    tau_before: np.ndarray | None = None
    needed: np.ndarray | None = None

    def check(self, robot: Robot) -> None:
        """Raises ValueError for shapes that do not fit the robot and for values that are not finite."""
        n, samples = len(robot.coordinates), len(self.q)
        shapes = {"q": (samples, n), "dq": (samples, n), "ddq": (samples, n), "time": (samples,)}
        shapes |= {name: (samples, len(robot.joints)) for name in ("tau", "tau_before", "needed")}
        for name, shape in shapes.items():
            values = getattr(self, name)
            if values is None:
                continue
            if np.shape(values) != shape:
                raise ValueError(
                    f"motion.{name} of robot {robot.name} has shape {np.shape(values)}, not {shape}"
                )
            if not np.isfinite(values).all():
                at = int(np.argwhere(~np.isfinite(values))[0, 0])
                raise ValueError(f"motion.{name} of robot {robot.name} is not finite at sample {at}; drop it")
