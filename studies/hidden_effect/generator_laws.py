"""Every hidden law by its name."""

from . import (  # their import registers the laws
    generator_drive,
    generator_friction,
    generator_outside,
    generator_transmission,
)
from .generator_law import LAWS, Draw, Law, Levels

__all__ = ["LAWS", "Draw", "Law", "Levels"]
_MODULES = (generator_drive, generator_friction, generator_outside, generator_transmission)
