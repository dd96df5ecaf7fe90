"""A robot file against its schema, by the package jsonschema: what is wrong first, in one sentence."""

from collections.abc import Iterable, Mapping
from math import isfinite
from typing import TYPE_CHECKING, Any

from flexmodels.files.toml_table import LARGEST_NUMBER, shortened
from flexmodels.robot import RobotError

if TYPE_CHECKING:
    from jsonschema import ValidationError

_KINDS = {
    "number": "a finite number",
    "integer": "a whole number",
    "array": "a list",
    "object": "a table",
    "string": "a text",
    "boolean": "true or false",
}


def validate(data: Mapping[str, Any], schema: Mapping[str, Any]) -> None:
    """Raises RobotError that names the key, unless `data` obeys the schema."""
    from jsonschema import Draft202012Validator
    from jsonschema.validators import extend

    numbers = {"number": lambda _, value: _finite(value), "integer": lambda _, value: _whole(value)}
    checker = Draft202012Validator.TYPE_CHECKER.redefine_many(numbers)
    error = _first(extend(Draft202012Validator, type_checker=checker)(schema).iter_errors(data))
    if error is not None:
        raise RobotError(_sentence(_within(error)))


def _finite(value: Any) -> bool:
    """A number of TOML that arithmetic can use; infinite and endless ones are none."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return False
    return abs(value) <= LARGEST_NUMBER  # not a number is not


def _whole(value: Any) -> bool:
    return _finite(value) and value == int(value)


def _first(errors: "Iterable[ValidationError]") -> "ValidationError | None":
    """Unknown keys come last: a key that is missing is often one of these, misspelt."""
    return min(errors, key=lambda error: error.validator == "additionalProperties", default=None)


def _within(error: "ValidationError") -> "ValidationError":
    """Of several forms that a value may have, what is wrong in the one that it nearly has."""
    while error.validator == "anyOf":
        forms: dict[Any, list[ValidationError]] = {}
        for one in error.context or ():
            forms.setdefault(one.schema_path[0], []).append(one)
        near = {form: listed for form, listed in forms.items() if not _of_other_kind(listed)}
        if not near:
            return error
        inner = _first(min(near.values(), key=lambda listed: (len(listed), -_depth(listed))))
        assert inner is not None
        error = inner
    return error


def _of_other_kind(errors: "Iterable[ValidationError]") -> bool:
    return any(error.validator == "type" and not error.relative_path for error in errors)


def _depth(errors: "Iterable[ValidationError]") -> int:
    return max(len(error.relative_path) for error in errors)


def _sentence(error: "ValidationError") -> str:
    place = _place(error.absolute_path)
    rule: Any = error.validator_value
    sentences = {
        "required": lambda: f"{_key(place, _missing(error))} is missing",
        "additionalProperties": lambda: _unknown(place, error),
        "minimum": lambda: f"{place} = {shortened(error.instance)} must be at least {rule:g}",
        "exclusiveMinimum": lambda: f"{place} = {shortened(error.instance)} must be above {rule:g}",
        "maximum": lambda: f"{place} = {shortened(error.instance)} must be at most {rule:g}",
        "enum": lambda: f"{place} must be {_listed(rule)}, not {shortened(error.instance)}",
        "const": lambda: f"{place} must be true or false, not {shortened(error.instance)}",
        "anyOf": lambda: f"{place} must be {_forms(rule)}, not {shortened(error.instance)}",
    }
    return sentences.get(str(error.validator), lambda: f"{place} {_kind(error)}")()


def _kind(error: "ValidationError") -> str:
    """What a value must be that has a wrong type, or a list of a wrong length."""
    wanted, value = _tables(error.schema, error.instance)
    kind = wanted.get("type")
    if kind == "array":
        item = wanted["items"]
        size = wanted["minItems"] if wanted.get("minItems") == wanted.get("maxItems") else None
        if item.get("type") in ("number", "integer"):
            return f"must be {size} numbers" if size else "must be a list of numbers"
        if item.get("type") == "string" or "enum" in item:
            return "must be a list of texts"
        return f"must be a list of tables ([[{error.absolute_path[-1]}]])"
    if kind == "number" and isinstance(value, int | float) and not isinstance(value, bool):
        limit = f" up to {LARGEST_NUMBER:g}" if isinstance(value, int) or isfinite(value) else ""
        return f"must be a finite number{limit}, not {shortened(value)}"
    if kind == "object":
        return "must be a table"
    return f"must be {_KINDS[str(kind)]}, not {shortened(value)}"


def _missing(error: "ValidationError") -> str:
    needed, table = _tables(error.validator_value, error.instance)
    return next(key for key in needed if key not in table)


def _unknown(place: str, error: "ValidationError") -> str:
    schema, table = _tables(error.schema, error.instance)
    known = schema["properties"]
    key = _key(place, min(set(table) - set(known)))[:80]
    if list(error.absolute_path)[-1:] == ["effects"]:
        return f"{key} is not a known effect; known are {', '.join(sorted(known))}"
    return f"{key} is not a known key; remove or rename it"


def _tables(*given: Any) -> tuple[Any, ...]:
    """As they are; the package calls them values that may be missing."""
    return given


def _forms(forms: list[dict[str, Any]]) -> str:
    return _listed([_KINDS[form["type"]] for form in forms])


def _listed(values: list[Any]) -> str:
    *others, last = map(str, values)
    return f"{', '.join(others)} or {last}" if others else last


def _place(path: Iterable[str | int]) -> str:
    """Keys with dots between, numbers of a list from 1 as people count."""
    place = ""
    for step in path:
        place = f"{place}[{step + 1}]" if isinstance(step, int) else _key(place, step)
    return place


def _key(place: str, key: str) -> str:
    return f"{place}.{key}" if place else key
