"""A robot fitted to logs, what it misses of those that judge it, and the floor of that among replicas."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

from flexmodels.robot import Robot
from pyident.comparison.compare import log_errors
from pyident.comparison.errors import LogErrors
from pyident.comparison.model_against_replicas import Part, Progress, judged_logs, run_trial
from pyident.comparison.trial import Trial
from pyident.diagnosis.base.setting import Setting, in_closed_loop, set_up, unbiased
from pyident.extension.split import Split
from pyident.rules.rules import Rules
from pyident.simulation.denoised import unfiltered
from pyident.simulation.replica import Repeat, repeat_like
from pyident.simulation.simulator import OpenPool


@dataclass(frozen=True)
class Fit:
    """data, replicas: parts of the fitted logs, so many as `fitted`, then of those held out.

    setting, asked   in closed loop and free of bias; and as a diagnosis looks at the fitted logs
    """

    setting: Setting
    asked: Setting
    trial: Trial
    fitted: int
    data: list[Part]
    replicas: list[list[Part]] = field(default_factory=list)

    @cached_property
    def unseen(self) -> tuple[LogErrors, ...]:
        """On held-out data."""
        return self._errors(range(self.fitted, len(self.data)))

    @cached_property
    def seen(self) -> tuple[LogErrors, ...]:
        """On fitted data."""
        return self._errors(range(self.fitted))

    def beside(self, replicas: list[list[Part]]) -> "Fit":
        """The same fit above the floor of another's."""
        return replace(self, replicas=replicas)

    def _errors(self, logs: Sequence[int]) -> tuple[LogErrors, ...]:
        return tuple(
            log_errors(self.trial, i, self.data[i], [parts[i] for parts in self.replicas]) for i in logs
        )


def fit_to(
    robot: Robot, parts: Split, open_pool: OpenPool, rules: Rules, progress: Progress, replicas: int = 0
) -> Fit:
    """replicas: how many tell the floor; none: there is no floor.

    Raises LogError and what the simulation raises.
    """
    start, plain = set_up(robot, parts.fitted, rules), unfiltered(robot, parts.fitted)
    setting = in_closed_loop(start, parts.fitted)
    with open_pool(setting.simulated) as workers:
        setting = unbiased(setting, workers)
        asked = setting if start.simulates else start
        if not start.simulates and plain is not robot:
            asked = set_up(plain, parts.fitted, rules)
        fit = Fit(setting, asked, _on_trial(start, setting, parts), len(parts.fitted), [])
        if not replicas:
            return replace(fit, data=judged_logs(fit.trial, workers))
        data, made = run_trial(fit.trial, workers, progress, replicas)
        return replace(fit, data=data, replicas=made)


def _on_trial(start: Setting, setting: Setting, parts: Split) -> Trial:
    """setting: the start in closed loop. Where that stands in, all is judged without the encoders' noise."""
    judged = tuple(repeat_like(setting.simulated, setting.robot, log) for log in parts.judged)
    fitted = tuple(r for r in setting.repeats if isinstance(r, Repeat))
    trial = Trial(
        setting.robot,
        setting.simulated,
        fitted,
        (*fitted, *judged),
        (*(0.0 for _ in fitted), *parts.since),
        setting.noise,
        setting.estimator,
    )
    return trial if start.simulates else trial.along(start.robot, start.solution.p)
