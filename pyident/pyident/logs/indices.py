"""`{k}` in names, with arithmetic: `q{k}`, `col{k+13}`, `m{2*k-1}`."""

import ast
import operator
import re

from pyident.logs.log import LogError

_FIELD = re.compile(r"\{([^{}]*)\}")
_DOES = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.FloorDiv: operator.floordiv,
    ast.Mod: operator.mod,
}
_LARGEST = 10**6


def indexed(pattern: str) -> bool:
    """Whether a name stands for one per joint."""
    return _FIELD.search(pattern) is not None


def at_joint(pattern: str, k: int) -> str:
    """The name for joint k. Raises LogError for anything but whole numbers, k, + − * // % and brackets."""
    return _FIELD.sub(lambda field: str(_value(field[1], k, pattern)), pattern)


def _value(text: str, k: int, pattern: str) -> int:
    try:
        value = _evaluated(ast.parse(text.strip(), mode="eval").body, k)
    except (SyntaxError, ValueError, ZeroDivisionError, RecursionError, MemoryError):
        raise LogError(
            f"{{{text}}} in {pattern!r} is no whole number; write {{k}} or, say, {{k+13}}"
        ) from None
    if abs(value) > _LARGEST:
        raise LogError(f"{{{text}}} in {pattern!r} is too large a number")
    return value


def _evaluated(node: ast.expr, k: int) -> int:
    if isinstance(node, ast.Name) and node.id == "k":
        return k
    if isinstance(node, ast.Constant) and type(node.value) is int and abs(node.value) <= _LARGEST:
        return node.value
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
        return -_evaluated(node.operand, k)
    if isinstance(node, ast.BinOp) and type(node.op) in _DOES:
        return _DOES[type(node.op)](_evaluated(node.left, k), _evaluated(node.right, k))
    raise ValueError
