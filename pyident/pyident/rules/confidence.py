"""How sure a statement is, wherever it is printed."""

CONFIDENCE = 1.96  # standard deviations on both sides hold 95 % of a normal distribution
LEVEL = 0.05  # chance of a finding where there is none
PERIODS = 3.0  # that an angle must have passed for what depends on it to be periodic: a hose bends twice
