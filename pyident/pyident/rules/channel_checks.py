"""Thresholds by which one channel of a log is looked at, in time and over its rows."""

from dataclasses import dataclass

from pyident.rules.rule import in_range, rule

_BENCH = (
    "by hand, on the logs of studies/log_checks as they were gathered; half or twice as much changes none"
)
_FLAGS = "by hand, on the logs of studies/log_checks as they were gathered; half as much flags a good one"


@dataclass(frozen=True)
class ChannelCheckRules:
    """Jumps, values that stay, steps of an encoder, rows; shares are of one."""

    fewest_rows: int = rule(50, "rows of a log", "with fewer, nothing can be said", _BENCH)
    large_jump: float = rule(0.02, "a channel's range, size of a jump", "no fit survives more", _BENCH)
    tiny_jump: float = rule(1e-5, "a channel's range, size of a jump", "less does no harm", _BENCH)
    alone: float = rule(
        10.0, "the steps around a jump", "less is a motion that starts and stops", "no data: what joints do"
    )
    stopped: float = rule(0.2, "the steps of the motion on the other side", "less stands", "by reason")
    noisy: float = rule(0.03, "a position's range, its noise", "the coarsest encoder has less", _BENCH)
    whole_turns: float = rule(
        0.02, "turns per sample, median", "of a faster joint, a jump of a turn is no jump", _BENCH
    )
    encoder_steps: float = rule(
        40.0, "steps of the encoder in a fourth difference", "less is rounding", _BENCH
    )
    bent_ends: int = rule(
        25, "samples at either end that are left out", "a filter without phase shift bends them", _FLAGS
    )
    braking: float = rule(
        0.01, "s between samples", "with more, a joint may start or stop from one to the next", _BENCH
    )
    ringing: int = rule(
        25, "samples after a motor's jump of acceleration", "a hinge rings that long", "by reason"
    )
    few: int = rule(3, "single odd samples of a torque", "fewer are accidents", _FLAGS)
    wide_spike: float = rule(1.0, "the range of all other samples", "less may be a torque's peak", _BENCH)
    turning: int = rule(
        3,
        "samples on either side of a joint's reversal, stop or start",
        "dry friction jumps there; a torque may be a sample or two late",
        "by reason",
    )
    still: float = rule(
        4.0, "an angle's noise, over that many samples", "less is no motion", "by reason: 2.8 deviations"
    )
    many: float = rule(0.002, "the samples that are odd", "with more, the log is refused", _BENCH)
    neighbours: int = rule(
        6, "runs on either side with which a stuck one is compared", "more are of another motion", _BENCH
    )
    repeats: float = rule(
        0.2,
        "samples of a torque that repeat the one before",
        "with more, its steps are coarser than its noise, and a long stay is its manner",
        "by reason, beside simulated arms that go from pose to pose, currents in steps: 0.28 to 0.86",
    )
    at_speed: float = rule(
        0.25, "a joint's rms speed that it has at the end of its channel", "a crest is met at rest", _BENCH
    )
    frozen: float = rule(0.1, "s that a torque keeps one value", "less is a slow bus", _BENCH)
    way: float = rule(
        0.03, "a joint's range that it goes while its torque is frozen", "less may be rest", _BENCH
    )
    standing: int = rule(30, "steps of the encoder", "an axis that moves by less stands still", _BENCH)
    busy: float = rule(0.7, "the channels that change in a row", "a log that moves has more", _FLAGS)

    def __post_init__(self) -> None:
        shares = "large_jump", "tiny_jump", "many", "way", "busy", "noisy", "stopped"
        in_range(self, "channel_checks", 0, 1, *shares)


CHANNELS = ChannelCheckRules()
