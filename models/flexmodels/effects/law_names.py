"""What a law and its parameters may be called: they become names of columns, in C, in XML and on pages."""

import re
from collections.abc import Mapping

_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,63}")
_PARAMETER = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,63}(\[[0-9a-z]{1,8}\])?")
_UNIT = re.compile(r"[A-Za-z0-9./()%*^-]{1,40}")


class EffectError(ValueError):
    """A law that cannot be used; the message names the effect and the cure."""


def check_names(effect: str, parameters: Mapping[str, str], states: Mapping[str, str]) -> None:
    """Raises EffectError unless every name is one word of ASCII and every unit (the values) a unit."""
    if not isinstance(effect, str) or not _NAME.fullmatch(effect):
        raise EffectError(f"effect {effect!r} must be named by ASCII letters, digits and _, a letter first")
    for kind, names in (("parameter", parameters), ("state", states)):
        for name, unit in names.items():
            if not isinstance(name, str) or not _PARAMETER.fullmatch(name):
                raise EffectError(
                    f"effect {effect}: {kind} {name!r} must be named by ASCII letters, digits and _"
                )
            if not isinstance(unit, str) or not _UNIT.fullmatch(unit):
                raise EffectError(
                    f"effect {effect}: {unit!r} of {name} is no unit; write one such as N.m.s/rad"
                )
