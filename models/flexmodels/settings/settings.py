"""What stands beside a robot: how its logs are read and prepared, and its own experiments."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from flexmodels.settings.motions import Identification, Line
from flexmodels.settings.processing import Column, Processing


@dataclass(frozen=True)
class Settings:
    """None of it changes the equations of the robot.

    columns          signal -> where files recorded elsewhere have it
    processing       how logs are prepared for identification
    identification   its experiment, None where nothing is planned
    line             a straight motion of its tip, likewise
    """

    columns: Mapping[str, Column] = field(default_factory=dict)
    processing: Processing = field(default_factory=Processing)
    identification: Identification | None = None
    line: Line | None = None
