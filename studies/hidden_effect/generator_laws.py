"""Every hidden law by its name."""

from studies.hidden_effect import (  # their import registers the laws
    generator_drive,
    generator_friction,
    generator_outside,
    generator_transmission,
)
from studies.hidden_effect.generator_law import LAWS, Draw, Law, Levels

__all__ = ["LAWS", "Draw", "Law", "Levels"]
_MODULES = (generator_drive, generator_friction, generator_outside, generator_transmission)
