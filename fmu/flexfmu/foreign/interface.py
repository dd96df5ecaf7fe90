"""The two ways in which an FMU is run."""

from typing import Literal

Interface = Literal["CoSimulation", "ModelExchange"]
