"""What data and replicas share: the fitted robot, how each log is made again, noise, the bias of the fit."""

from collections.abc import Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, field, replace

import numpy as np

from flexmodels.inputs import SimulationError
from flexmodels.robot import Robot
from pyident.conditioning.alignment import NOTHING, Alignment
from pyident.estimation.base_parameters import supports
from pyident.estimation.estimator import Estimator, weighted
from pyident.estimation.identify import identified
from pyident.estimation.least_squares import Solution
from pyident.logs.log import Log
from pyident.refinement.auxiliary_model import robot_by_instruments
from pyident.refinement.instruments.missed import NotFollowedError
from pyident.refinement.instruments.simulated_rows import lightest_rotors
from pyident.refinement.instruments.stand_in import driven
from pyident.refinement.remove_bias import seen
from pyident.regression.equations import Problem
from pyident.regression.loads.swinging_drive import Springs
from pyident.regression.reduced import Reduced
from pyident.rules.rules import RULES, Rules
from pyident.simulation.along import AlongMotion, along_each, mean_noise
from pyident.simulation.denoised import denoised, denoises
from pyident.simulation.noise.sensor_noise import sensor_noise, torque_noise
from pyident.simulation.processes.tools import inline
from pyident.simulation.recorded import loop_of
from pyident.simulation.replica import Repeat, repeats, torque_spectra, with_sensors
from pyident.simulation.simulator import OpenPool, Simulator, Unsimulated, Workers

_FITTED = "_identified"  # behind the name of a robot
_SOFTEST = 0.1  # of the stiffness in the middle of a hinge's
_STIFFEST = 10.0  # times the damping of the hinge in the middle
_TOGETHER = 5  # replicas that one process simulates at once: more fill its vectors, fewer fill the cores


@dataclass(frozen=True)
class Setting:
    """What data and replicas share: the fitted robot, how each log is repeated, the sensors' noise.

    solver   the FMU's own parameters for the replicas
    rules    every threshold
    own_noise   log -> noise of its own, where it tells it
    estimator   by which logs and replicas are fitted alike
    alignment   what kept positions and torques of the logs apart, which is put right
    bends   springs of drives, about which their bends are described, each beside those before it
    late    time [s] by which all positions still are late, where the fit by instruments is sure of it
    unfollowed   why no simulation of the fit follows the logs: then replicas are the logs themselves with
            their sensors' noise once more, which show nothing of what the fit bends; empty: one does
    """

    robot: Robot
    simulated: Robot
    repeats: tuple[Repeat | AlongMotion, ...]
    noise: dict[str, float]
    reduced: Reduced
    solution: Solution
    solver: Mapping[str, float] = field(default_factory=dict)
    own_noise: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    rules: Rules = RULES
    estimator: Estimator = weighted
    alignment: Alignment = NOTHING
    bends: Springs = field(default_factory=dict)
    late: float = 0.0
    unfollowed: str = ""

    @property
    def logs(self) -> list[Log]:
        return [r.log for r in self.repeats]

    @property
    def period(self) -> float:
        """[s] of the log with the fewest samples a second."""
        return max(log.period for log in self.logs)

    @property
    def simulates(self) -> bool:
        """Whether its replicas are simulated, else they go along the measured motion."""
        return all(isinstance(r, Repeat) for r in self.repeats)

    @property
    def follows(self) -> bool:
        """Whether its replicas are simulations that follow the logs."""
        return self.simulates and not self.unfollowed

    @property
    def continued(self) -> np.ndarray:
        """(logs, n) Hz: below, the noise of an equation's torque is not measured but continued."""
        found = np.zeros((len(self.repeats), len(self.robot.coordinates)))
        for own, r in zip(found, self.repeats, strict=True):
            measured = torque_spectra(r)
            if measured:
                own[: len(self.robot.joints)] = [measured[name].continued for name in self.robot.torques]
        return found


def set_up(
    robot: Robot,
    logs: Sequence[Log],
    rules: Rules = RULES,
    estimator: Estimator = weighted,
    alignment: Alignment = NOTHING,
) -> Setting:
    """Fit the robot to the logs and prepare its replicas. Raises LogError.

    alignment   what kept their positions and torques apart, and was put right in them
    """
    found = estimator(Problem(robot, tuple(denoised(robot, log) for log in logs)))
    reduced, solution = found.reduced, found.solution
    setting = Setting(robot, robot, (), {}, reduced, solution, {}, {}, rules, estimator, alignment)
    if robot.controller or robot.servo or robot.flexible:
        fitted = _fitted(robot, reduced, solution)
        loop_is_known = all(loop_of(fitted, log) is None for log in logs)
        if loop_is_known or robot.flexible:
            noise = sensor_noise(fitted, logs, solution.p)
            own = {log.source: torque_noise(fitted, [log]) for log in logs}
            return _repeated(replace(setting, robot=fitted, noise=noise, own_noise=own), logs)
    fitted = _along_model(robot, reduced, solution)
    paths = along_each(fitted, logs, solution.p, solution.covariance, rules.periodic)
    own = {path.log.source: {name: of.std for name, of in path.noise.items()} for path in paths}
    noise = mean_noise(paths)
    return replace(setting, robot=fitted, simulated=fitted, repeats=paths, noise=noise, own_noise=own)


def _fitted(robot: Robot, reduced: Reduced, solution: Solution) -> Robot:
    """The robot with the physically consistent parameters nearest to a solution."""
    return _with_own(robot, identified(robot, reduced, solution).robot, reduced, solution)


def _with_own(robot: Robot, fitted: Robot, reduced: Reduced, solution: Solution) -> Robot:
    """A fit with the robot's own values of what shows in no equation at a joint, as where it stands still.

    The bounds alone would make it small: a motor without inertia that nothing holds.
    """
    told = supports(reduced, solution).items()
    unseen = [name for name, support in told if support == "no" and not name.startswith("link")]
    return fitted.with_parameters({name: robot.parameters[name] for name in unseen})


def _along_model(robot: Robot, reduced: Reduced, solution: Solution) -> Robot:
    """The robot with the parameters of a solution, physical or not: whose torques are needed, not its motion.

    Where a model lacks something, the nearest bodies that can be may be far from what the logs say.
    """
    if not denoises(robot):
        return _fitted(robot, reduced, solution)
    name = robot.name if robot.name.endswith(_FITTED) else f"{robot.name}{_FITTED}"
    return robot.with_parameters(dict(zip(reduced.columns, solution.p.tolist(), strict=True)), name)


def in_closed_loop(setting: Setting, logs: Sequence[Log]) -> Setting:
    """The setting whose replicas are simulated under the robot's controller, or one that stands in for it."""
    if setting.simulates:
        return setting
    fitted = _fitted(setting.robot, setting.reduced, setting.solution)
    return _repeated(replace(setting, robot=fitted, noise=_with_rounding(setting)), logs)


def _with_rounding(setting: Setting) -> dict[str, float]:
    """Its noise, and what rounding adds, which replicas along the measured motion do by themselves."""
    steps = [path.steps for path in setting.repeats if isinstance(path, AlongMotion)]
    rounding = {name: np.mean([own[name] for own in steps]) / np.sqrt(12) for name in setting.noise}
    return {name: float(np.hypot(sigma, rounding[name])) for name, sigma in setting.noise.items()}


def _repeated(setting: Setting, logs: Sequence[Log]) -> Setting:
    """In closed loop; the robot is one that can be simulated."""
    simulated, made_again = repeats(setting.robot, logs)
    return replace(setting, simulated=simulated, repeats=with_sensors(setting.robot, made_again))


def _unsimulated() -> AbstractContextManager[Simulator]:
    return nullcontext(Unsimulated())


def workers_of(setting: Setting, open_pool: OpenPool) -> AbstractContextManager[Workers]:
    """Processes for the setting's replicas: with its FMU where they are simulated."""
    return open_pool(setting.simulated) if setting.follows else inline(_unsimulated)


def unbiased(
    setting: Setting, workers: Workers, rounds: int | None = None, probes: int | None = None
) -> Setting:
    """The setting with parameters that are free of the regression's bias, which noise and sampling make.

    Where the model can be simulated and follows the logs, by instruments: noise of a position may leave a
    regression a fifth of a stiffness. Else with those whose replicas the regression finds where it found the
    data, as in `refinement.remove_bias`.
    """
    if setting.simulates and setting.estimator is weighted:
        found = _by_instruments(setting, workers)
        if found is not None:
            return found
    rules, found = setting.rules.replicas, setting.solution.p
    probes = rules.probes if probes is None else probes
    for number in range(rules.rounds if rounds is None else rounds):
        seeds = range(-1 - number * probes, -1 - (number + 1) * probes, -1)
        jobs = [workers.submit(_refitted, setting, group) for group in together(seeds)]
        put_in = np.array(list(setting.robot.linear_parameters.values()))
        refits = [p for job in jobs for p in job.result()]
        change = seen(setting.solution, found - np.mean(refits, axis=0))
        solution = replace(setting.solution, p=put_in + change)
        if setting.simulates:
            robot = _fitted(setting.robot, setting.reduced, solution)
        else:
            robot = _along_model(setting.robot, setting.reduced, solution)
        simulated = setting.simulated.with_parameters(robot.parameters)
        setting = replace(setting, robot=robot, simulated=simulated)
    return setting


def _by_instruments(setting: Setting, workers: Workers) -> Setting | None:
    again = [r for r in setting.repeats if isinstance(r, Repeat)]
    try:
        robot, late = robot_by_instruments(setting.robot, setting.logs, again, workers)
    except (SimulationError, NotFollowedError):
        return None
    robot = _with_own(setting.robot, robot, setting.reduced, setting.solution)
    simulated = setting.simulated.with_parameters(robot.parameters)
    return replace(setting, robot=robot, simulated=simulated, repeats=with_sensors(robot, again), late=late)


def steadied(setting: Setting) -> Setting:
    """The setting for a fit that cannot be simulated: small steps, no hinge without spring or damping.

    No rotor is lighter than its controller can hold.

    What a model lacks may bend its fit that far. A stiffness is taken as at least a tenth of the one in the
    middle of its hinge's, damping as about proportional to it, with the ratio of the hinge in the middle.
    """
    values = dict(setting.robot.parameters)
    for number, _ in setting.robot.numbered:
        own = [k for k in values if k.startswith(f"joint{number}.k[")]
        if own:
            least = _SOFTEST * float(np.median([values[k] for k in own]))
            values |= {k: max(values[k], least) for k in own}
    pairs = {d: d.replace(".d[", ".k[") for d in values if ".d[" in d}
    ratio = float(np.median([values[d] / values[k] for d, k in pairs.items() if values[k] > 0] or [0.0]))
    held = {k: values[k] for k in pairs.values()}
    held |= {name: max(values[name], least) for name, least in lightest_rotors(setting.robot).items()}
    most = _STIFFEST if driven(setting.robot) else np.inf  # what stands in for a loop is slow enough
    held |= {d: _within(values[d], ratio * values[k], most) for d, k in pairs.items()}
    return replace(
        setting,
        robot=setting.robot.with_parameters(held),
        simulated=setting.simulated.with_parameters(held),
        solver={"solver.step": setting.rules.replicas.step},
    )


def _within(damping: float, usual: float, most: float) -> float:
    """A damping not below the usual one, nor many times above it: what no step of a solver follows."""
    return min(max(damping, usual), most * usual) if usual > 0 else damping


def together(seeds: Sequence[int]) -> list[Sequence[int]]:
    """Seeds of the replicas that one process makes side by side."""
    return [seeds[at : at + _TOGETHER] for at in range(0, len(seeds), _TOGETHER)]


def replicas_of(
    fmu: Simulator, setting: Setting, repeats: Sequence[Repeat | AlongMotion], seeds: Sequence[int]
) -> list[tuple[Log, ...]]:
    """Logs as the setting's robot would have made them, all of them once per seed."""
    chance = [np.random.default_rng(np.abs([seed, int(seed < 0)])) for seed in seeds]
    drawn = np.array([rng.integers(2**31, size=len(repeats)) for rng in chance])
    parameters = setting.robot.parameters | dict(setting.solver)
    made = []
    for r, own in zip(repeats, drawn.T.tolist(), strict=True):
        noise = {**setting.noise, **setting.own_noise.get(r.log.source, {})}
        if isinstance(r, AlongMotion):
            made.append(r.replicas(parameters, own))
        else:
            made.append(r.replicas(fmu, parameters, noise, own))
    return list(zip(*made, strict=True)) or [()] * len(seeds)


def _refitted(fmu: Simulator, setting: Setting, seeds: Sequence[int]) -> list[np.ndarray]:
    """What the regression finds in replicas."""
    robot, found = setting.robot, []
    for logs in replicas_of(fmu, setting, setting.repeats, seeds):
        problem = Problem(robot, tuple(denoised(robot, log) for log in logs))
        found.append(setting.estimator(problem, setting.solution).solution.p)
    return found
