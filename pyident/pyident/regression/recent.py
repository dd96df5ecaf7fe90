"""The last things made of the same objects, for what a search asks for again and again."""

from collections import OrderedDict
from collections.abc import Callable, Hashable
from typing import Generic, TypeVar

T = TypeVar("T")


class Recent(Generic[T]):
    """Keeps the `most` asked for last, and with them the objects that they were made of."""

    def __init__(self, most: int):
        self._most = most
        self._kept: OrderedDict[Hashable, tuple[tuple[object, ...], T]] = OrderedDict()

    def of(self, objects: tuple[object, ...], make: Callable[[], T], key: Hashable = None) -> T:
        """What `make` gives, or gave for these very objects and an equal key."""
        place = (*map(id, objects), key)  # of objects that are kept, so that no other gets their address
        if place in self._kept:
            self._kept.move_to_end(place)
            return self._kept[place][1]
        made = make()
        self._kept[place] = objects, made
        if len(self._kept) > self._most:
            self._kept.popitem(last=False)
        return made
