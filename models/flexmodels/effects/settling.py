"""A course of time that settles, as of what warms up: it sets out like time itself and ends at a level."""

from dataclasses import replace

from sympy import exp

from flexmodels.effects.effect import Parameter
from flexmodels.effects.signals import time

# Of logs that begin when the robot does: from a tenth of their length to a straight line.
settling = Parameter("settling", "s", start=1e6, lower=0.01, grid=(0.15, 0.5, 1.5, 100.0), scale=time)
# Of a torque by itself: one that settled at once would be a constant.
slow_settling = replace(settling, grid=(0.75, 1.5, 100.0))
elapsed = settling.symbol * (1 - exp(-time / settling.symbol))
