"""The last things made of the same objects, for what a search asks for again and again."""

from collections import deque
from collections.abc import Callable
from typing import Generic, TypeVar

T = TypeVar("T")


class Recent(Generic[T]):
    """Keeps the `most` made last, and with them the objects that they were made of."""

    def __init__(self, most: int):
        self._kept: deque[tuple[tuple[object, ...], object, T]] = deque(maxlen=most)

    def of(self, objects: tuple[object, ...], make: Callable[[], T], key: object = None) -> T:
        """What `make` gives, or gave for these very objects and an equal key."""
        for known, known_key, made in tuple(self._kept):
            if known_key == key and all(a is b for a, b in zip(known, objects, strict=True)):
                return made
        made = make()
        self._kept.append((objects, key, made))
        return made
