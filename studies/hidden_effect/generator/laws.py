"""Every hidden law by its name."""

from . import drive, friction, outside, transmission  # their import registers the laws
from .law import LAWS, Draw, Law, Levels

__all__ = ["LAWS", "Draw", "Law", "Levels"]
_MODULES = (drive, friction, outside, transmission)
