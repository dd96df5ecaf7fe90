"""Every threshold by which a log is called wrong or doubtful. None was tuned on a case of the test bench."""

from dataclasses import dataclass


@dataclass(frozen=True)
class LogCheckRules:
    """Thresholds of the checks of a log; shares are of one, times in samples unless a unit is named.

    gap_rows              a value that stays for more samples than this may be stuck
    freeze                how many times longer a stuck run is than those around it
    catch_up              times its largest other step that a stuck channel jumps by when it goes on
    at_limit              share of the samples at a channel's extreme that makes a limit
    crowded               times the mean of the next bins: the crest of a sine gives 3.4
    limit_gross           share of the samples at the limit from which a torque is useless
    limit_bin             width of a bin at the extreme, as a share of a channel's range
    odd                   robust standard deviations of fourth differences that make a jump
    beyond                times what all but one in a hundred of the fourth differences are
    coarse                times the acceleration's rms that rounding may make: with more, it is mostly noise
    slowest_update        slowest update of a channel that is looked for
    on_the_beat           share of a channel's changes that fall on every m-th sample
    spike                 times the spread of a torque that a single sample must stick out
    drift                 samples that a clock may be away from a uniform one
    shortest_period       [s] a faster sampled log of a robot is not believed without asking
    longest_period        [s] a slower one neither
    impossible_period     [s] slower than this no motion of a robot is sampled
    rate_ratio            times slower or faster than the robot's controller that a log may be
    shuffled              rms of a channel's steps, as a share of its spread, where rows are out of order
    same                  relative difference below which two channels are one and the same
    fastest               [rad/s or m/s] a joint that moves faster is doubted
    impossible_speed      [rad/s or m/s] and one that moves faster than this refused
    beyond_limits         times the range of a joint's position limits that a log may cover
    sure                  standard deviations by which a friction, inertia or stiffness is negative
    friction_share        share of the exchanged power that friction must take to show a sign
    better                share of the residual's energy that a right transformation of channels leaves
    far_better            the same where the log is refused
    material              relative residual (rms) below which no transformation is looked for
    torque_scale          times that one joint's torque may be off what the other joints' torques say
    prior_doubtful        times that masses and inertias may be off the robot file's before it is said
    prior_gross           the same where the log is refused: units are off by 57.3 or more
    stiffness_doubtful    times that a stiffness may be off the robot file's before it is said
    stiffness_gross       the same where the log is refused
    delay                 samples: a torque that is later or earlier is named
    delay_gross           [s] and one that is off by more refused
    delay_material        relative residual (rms) that must be due to the delay
    unexplained           share of the torques' variance that no motion explains: they are of another log
    """

    gap_rows: int = 10
    freeze: float = 8.0
    catch_up: float = 2.0
    at_limit: float = 0.003
    crowded: float = 6.0
    limit_gross: float = 0.1
    limit_bin: float = 1e-3
    odd: float = 25.0
    beyond: float = 4.0
    coarse: float = 1.0
    slowest_update: int = 20
    on_the_beat: float = 0.98
    spike: float = 12.0
    drift: float = 0.5
    shortest_period: float = 2e-5
    longest_period: float = 0.15
    impossible_period: float = 0.5
    rate_ratio: float = 40.0
    shuffled: float = 0.6
    same: float = 1e-9
    fastest: float = 40.0
    impossible_speed: float = 150.0
    beyond_limits: float = 1.5
    sure: float = 6.0
    friction_share: float = 0.05
    better: float = 0.5
    far_better: float = 0.25
    material: float = 0.05
    torque_scale: float = 4.0
    prior_doubtful: float = 8.0
    prior_gross: float = 40.0
    stiffness_doubtful: float = 15.0
    stiffness_gross: float = 50.0
    delay: float = 0.75
    delay_gross: float = 0.03
    delay_material: float = 0.02
    unexplained: float = 0.5


LOG_CHECKS = LogCheckRules()
