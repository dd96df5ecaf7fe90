"""A mechanism as data: nodes, the elements that share them, and what each deformation is."""

from dataclasses import dataclass, fields
from functools import cached_property

import numpy as np

from pyident.kinematics.elements.beam import Beam
from pyident.kinematics.elements.hinge import Hinge
from pyident.kinematics.elements.nodes import Node
from pyident.kinematics.elements.slider import Slider

Element = Beam | Hinge | Slider
Mode = tuple[int, int]  # number of the element, number of its deformation, both from 0
GROUND: tuple[Node, ...] = (("x", 0), ("R", 0))


class StructureError(ValueError):
    """A structure whose deformations do not determine its nodes; the message says what to change."""


class ReachError(StructureError):
    """Coordinates at which a structure that is sound elsewhere does not close."""


@dataclass(frozen=True)
class Structure:
    """Elements listed from the ground outwards; translational and rotational nodes 0 are the ground.

    independent   the deformations that are the degrees of freedom, in the order of q
    released      the deformations that nothing holds; they follow from the motion
    bodies        per lumped body its translational and its rotational node
    Every other deformation is fixed at zero. What is held must just determine the nodes. A planar loop in
    space is overconstrained by three; as in a real machine, release a spherical and a universal joint's
    bendings there (they stay zero), rather than hold more than geometry allows.
    """

    elements: tuple[Element, ...]
    independent: tuple[Mode, ...]
    released: tuple[Mode, ...] = ()
    bodies: tuple[tuple[int, int], ...] = ()

    def __post_init__(self) -> None:
        self._check_names()
        self._check_order()
        held, unknown = len(self.rows), 3 * len(self.moving)
        if held != unknown:
            cure = f"release {held - unknown} more" if held > unknown else f"hold {unknown - held} more"
            raise StructureError(f"{held} held deformations for {unknown} nodal coordinates; {cure}")

    @cached_property
    def columns(self) -> tuple[tuple[int | None, ...], ...]:
        """Per element and mode its place in q, None where it is not independent."""
        place = {mode: j for j, mode in enumerate(self.independent)}
        return tuple(
            tuple(place.get((i, mode)) for mode in range(element.modes))
            for i, element in enumerate(self.elements)
        )

    @cached_property
    def held(self) -> tuple[tuple[Element, tuple[int, ...]], ...]:
        """Per element the modes that are fixed or independent."""
        return tuple(
            (element, tuple(mode for mode in range(element.modes) if (i, mode) not in self.released))
            for i, element in enumerate(self.elements)
        )

    @cached_property
    def rows(self) -> dict[Mode, int]:
        """The place of each held mode among all held modes."""
        modes = [(i, mode) for i, (_, held) in enumerate(self.held) for mode in held]
        return {mode: row for row, mode in enumerate(modes)}

    @cached_property
    def moving(self) -> tuple[Node, ...]:
        """Every node but the ground, in the order in which the elements name them."""
        named = [node for element in self.elements for node in element.inner + element.outer]
        return tuple(node for node in dict.fromkeys(named) if node not in GROUND)

    @cached_property
    def content(self) -> str:
        """All numbers of the structure as text, to the last digit."""
        elements = [
            (type(element).__name__, [np.asarray(getattr(element, f.name)).tolist() for f in fields(element)])
            for element in self.elements
        ]
        return repr((elements, self.independent, self.released, self.bodies))

    @cached_property
    def is_chain(self) -> bool:
        """Whether each element can place its outer nodes from inner ones already placed."""
        placed = set(GROUND)
        for i, element in enumerate(self.elements):
            deforms = isinstance(element, Beam) and any(j is not None for j in self.columns[i])
            if deforms or not placed.issuperset(element.inner) or not placed.isdisjoint(element.outer):
                return False
            placed.update(element.outer)
        return not self.released

    def _check_names(self) -> None:
        named = self.independent + self.released
        for i, mode in named:
            if not (0 <= i < len(self.elements) and 0 <= mode < self.elements[i].modes):
                raise StructureError(f"there is no deformation {mode} of element {i}; both count from 0")
            if named.count((i, mode)) > 1:
                raise StructureError(f"deformation {mode} of element {i} is listed twice; list it once")

    def _check_order(self) -> None:
        reached = set(GROUND)
        for i, element in enumerate(self.elements):
            if not reached.issuperset(element.inner):
                raise StructureError(f"element {i} starts at a node that none before it reaches; reorder")
            reached.update(element.outer)
