"""How wide an interval is said to be."""

CONFIDENCE = 1.96  # standard deviations on both sides hold 95 % of a normal distribution
