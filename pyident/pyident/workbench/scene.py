"""The arm in 3D: measured solid, simulated as a ghost; keyframes go to the browser once and play there."""

import json
from collections.abc import Sequence

import numpy as np
from nicegui import ui

_PLAY = """
(() => {
  const frames = %(frames)s, ids = %(ids)s, pairs = %(pairs)s;
  clearInterval(window.flexidentPlayer);
  const play = (scene) => {
    const mesh = (id) => scene.objects.get(id)?.mesh;
    let i = 0;
    const draw = () => {
      frames.forEach((arm, a) => arm[i].forEach((p, k) => mesh(ids[a].balls[k])?.position.set(...p)));
      frames.forEach((arm, a) => pairs.forEach(([from, to], k) => {
        const rod = mesh(ids[a].rods[k]);
        if (!rod) return;
        const p = from < 0 ? [0, 0, 0] : arm[i][from], q = arm[i][to];
        const d = [q[0] - p[0], q[1] - p[1], q[2] - p[2]], l = Math.max(Math.hypot(...d), 1e-6);
        rod.position.set((p[0] + q[0]) / 2, (p[1] + q[1]) / 2, (p[2] + q[2]) / 2);
        rod.scale.set(1, l, 1);
        const y = rod.up.clone().set(0, 1, 0), n = rod.up.clone().set(d[0] / l, d[1] / l, d[2] / l);
        rod.quaternion.setFromUnitVectors(y, n);
      }));
      i = (i + 1) %% frames[0].length;
    };
    draw();
    if (frames[0].length > 1) window.flexidentPlayer = setInterval(draw, %(step)g);
  };
  const wait = (tries) => {
    const scene = getElement(%(scene)d);
    if (scene?.objects?.get(ids[ids.length - 1].rods.at(-1))?.mesh) play(scene);
    else if (tries) setTimeout(() => wait(tries - 1), 100);
  };
  wait(100);
})();
"""

_SOLID, _GHOST = "#2b6ca3", "#b5480d"


class Arm3D:
    """A scene with one or two arms of the same tree. pairs: points that a link joins, -1 the base."""

    def __init__(self, pairs: Sequence[tuple[int, int]], reach: float, colours: Sequence[str], arms: int = 1):
        """reach: size of the arm [m]; colours: of the joints; arms: 2 with a ghost."""
        self.pairs, self.ids = list(pairs), []
        radius = 0.02 * reach
        with ui.scene(width=520, height=380, grid=(4, 20)).props(
            'data-testid="scene" aria-label="the robot in 3D"'
        ) as scene:
            self.scene = scene
            for colour, opacity in ((_SOLID, 1.0), (_GHOST, 0.35))[:arms]:
                balls = []
                for k in range(len(self.pairs)):
                    tone = colours[k] if k < len(colours) and opacity == 1.0 else colour
                    balls.append(scene.sphere(1.7 * radius).material(tone, opacity).id)
                rods = [
                    scene.cylinder(radius, radius, 1.0)
                    .material("#8a949e" if opacity == 1.0 else colour, opacity)
                    .id
                    for _ in self.pairs
                ]
                self.ids.append({"balls": balls, "rods": rods})
            scene.move_camera(1.2 * reach, -1.6 * reach, 1.1 * reach, 0, 0, 0.3 * reach, duration=0)

    def play(self, arms: Sequence[np.ndarray], milliseconds: float = 40.0) -> None:
        """Show motions (T, points, 3) [m]; one frame stands still."""
        script = _PLAY % {
            "scene": self.scene.id,
            "frames": json.dumps([np.round(arm, 5).tolist() for arm in arms]),
            "ids": json.dumps(self.ids[: len(arms)]),
            "pairs": json.dumps(self.pairs),
            "step": milliseconds,
        }
        ui.run_javascript(script)
