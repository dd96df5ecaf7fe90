"""Thresholds by which a log is called wrong or doubtful."""

from dataclasses import dataclass

from pyident.rules.rule import RulesError, in_range, rule

_BENCH = "the wrong and the good logs of studies/log_checks, while these were written"
_DRAWN = "random motions of seed 77 and the measured logs of studies/log_checks"
_KNOWN = "no data: what robots and recorders do"
_ARMS = (
    "by hand, on arms of two to six joints by Pinocchio that lack a law, warm up, bend, are late or stand at "
    "another place, half of them first slow and then fast"
)


@dataclass(frozen=True)
class LogCheckRules:
    """When a log is doubted and when it is refused; shares are of one."""

    gap_rows: int = rule(10, "samples that a value stays", "fewer are an encoder's at slow speed", _KNOWN)
    freeze: float = rule(8.0, "a stuck run over those around it", "less is a joint that slows down", _BENCH)
    catch_up: float = rule(
        2.0, "the jump after a stuck run over the largest other step", "less is a motion that goes on", _BENCH
    )
    at_limit: float = rule(0.003, "the samples at a channel's extreme", "less are a crest", _BENCH)
    crowded: float = rule(
        6.0, "samples in the last bin over the mean of the next", "the crest of a sine gives 3.4", _BENCH
    )
    limit_gross: float = rule(0.1, "the samples at the limit", "with more, the torque says little", _KNOWN)
    limit_bin: float = rule(1e-3, "a channel's range, width of a bin", "wider, and a crest fills it", _BENCH)
    odd: float = rule(25.0, "robust deviations of fourth differences", "less is noise with tails", _BENCH)
    beyond: float = rule(
        4.0, "the 99th percentile of fourth differences", "less is a motion with sharp ends", _BENCH
    )
    coarse: float = rule(
        1.0, "the acceleration's rms that rounding makes", "with more, it is mostly rounding", _KNOWN
    )
    slowest_update: int = rule(20, "samples between updates", "slower ones are seen as stuck", _KNOWN)
    on_the_beat: float = rule(
        0.98, "a channel's changes that fall on every m-th sample", "fewer are chance", _BENCH
    )
    spike: float = rule(12.0, "the usual distance of a torque from its neighbours", "less is noise", _BENCH)
    drift: float = rule(0.5, "samples that a clock is off a uniform one", "less is its rounding", _KNOWN)
    shortest_period: float = rule(2e-5, "s", "no recorder of a robot samples faster than 50 kHz", _KNOWN)
    longest_period: float = rule(0.15, "s", "a motion of a few Hz is lost beyond", _KNOWN)
    impossible_period: float = rule(0.5, "s", "no motion of a robot is sampled so slowly", _KNOWN)
    rate_ratio: float = rule(
        40.0, "the log's rate over the controller's, either way", "less is a thinned log, more a unit", _BENCH
    )
    shuffled: float = rule(
        0.6, "rms of a channel's steps over its spread", "shuffled rows give 1.4, motions far less", _BENCH
    )
    same: float = rule(1e-9, "relative difference of two channels", "more is not one and the same", _KNOWN)
    fastest: float = rule(40.0, "rad/s or m/s", "few robots' joints are faster", _KNOWN)
    impossible_speed: float = rule(150.0, "rad/s or m/s", "no robot's joint is faster", _KNOWN)
    beyond_limits: float = rule(
        1.5, "the range of a joint's position limits", "limits of files are often narrow", _BENCH
    )
    sure: float = rule(
        6.0, "standard deviations below zero", "residuals are not white, so deviations are too small", _BENCH
    )
    friction_share: float = rule(
        0.05, "the exchanged power that friction takes", "with less, its sign is not known", _BENCH
    )
    better: float = rule(
        0.5,
        "the residual's energy that another reading leaves",
        "a model that lacks a law gains some",
        _BENCH,
    )
    far_better: float = rule(0.25, "the same, to refuse the log", "less is doubtful only", _BENCH)
    material: float = rule(0.05, "relative residual (rms)", "with less, no other reading is needed", _BENCH)
    torque_scale: float = rule(
        4.0, "one joint's torque over what the others say, either way", "less may be a wrong inertia", _BENCH
    )
    prior_doubtful: float = rule(
        8.0, "masses and inertias over the robot file's, either way", "files are off by a few times", _BENCH
    )
    prior_gross: float = rule(40.0, "the same, to refuse the log", "units are off by 57.3 or more", _KNOWN)
    stiffness_doubtful: float = rule(
        15.0, "a stiffness over the robot file's, either way", "files guess stiffnesses", _BENCH
    )
    stiffness_gross: float = rule(
        50.0, "the same, to refuse the log", "units are off by 57.3 or more", _KNOWN
    )
    delay: float = rule(0.75, "samples", "a hold and a derivative make half a sample", _BENCH)
    delay_gross: float = rule(0.03, "s", "less is a filter or a bus, more another clock", _BENCH)
    delay_material: float = rule(0.02, "relative residual (rms)", "with less, a delay is no matter", _BENCH)
    common_delay: float = rule(
        0.75, "samples, beyond three standard deviations", "a hold makes half a sample", _DRAWN
    )
    delays_apart: float = rule(
        0.5,
        "samples beyond three standard deviations",
        "a recorder delays all joints alike, a law does not",
        _DRAWN,
    )
    torque_floor: float = rule(
        0.005, "a torque's rms that no fit is believed to reach", "less, and its delay seems certain", _DRAWN
    )
    shaken: float = rule(
        0.3, "the farthest joint's range", "less may be a joint that holds while others shake it", "by reason"
    )
    unexplained: float = rule(
        0.5, "the torques' variance that no motion explains", "with more, they are of another log", _BENCH
    )

    def __post_init__(self) -> None:
        shares = (
            "at_limit",
            "limit_gross",
            "on_the_beat",
            "friction_share",
            "better",
            "far_better",
            "material",
        )
        in_range(self, "log_checks", 0, 1, *shares, "unexplained", "delay_material")


LOG_CHECKS = LogCheckRules()


@dataclass(frozen=True)
class ChangeCheckRules:
    """When a step is believed; shares are of one."""

    edge: float = rule(0.1, "the log, at either end", "a part so short is fitted by anything", "by reason")
    light: float = rule(
        1e-3,
        "the largest joint's torque (rms), to which a lighter one counts",
        "a joint that carries nothing but rounding would outweigh all others",
        "by reason",
    )
    bends: tuple[float, ...] = rule(
        (0.1, 0.3, 0.5, 0.7, 0.9, 1.0),
        "quantiles of a joint's speed between which friction may bend",
        "with fewer, a slow half and a fast one are two machines",
        _ARMS,
    )
    body: float = rule(
        0.5,
        "the energy that one machine leaves, with another body from some instant on",
        "0.61 and more without a change",
        _ARMS,
    )
    friction: float = rule(
        0.25,
        "a joint's energy that one machine leaves, with another friction from some instant on",
        "0.39 and more without a change",
        _ARMS,
    )
    again: float = rule(
        0.75,
        "the energy left by a step, that a second one leaves",
        "what grows, or comes and goes, gains by every split; a step by the first",
        _ARMS,
    )

    def __post_init__(self) -> None:
        in_range(self, "change_checks", 0, 1, "light", "body", "friction", "again")
        in_range(self, "change_checks", 0, 0.4, "edge")
        if list(self.bends) != sorted(set(self.bends)) or not 0 <= self.bends[0] < self.bends[-1] <= 1:
            raise RulesError("rules: change_checks.bends must rise within 0 and 1")


CHANGES = ChangeCheckRules()
