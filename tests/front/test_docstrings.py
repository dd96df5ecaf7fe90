"""What the front door says of itself: every argument, and every error."""

import ast
import inspect
import re
from pathlib import Path

import pytest

import pyident as pi

FUNCTIONS = [name for name in pi.__all__ if inspect.isfunction(getattr(pi, name))]
ROOTS = {"models/flexmodels", "fmu/flexfmu", "pyident/pyident"}
PROJECT = Path(__file__).parents[2]


def _unsaid(name: str) -> set[str]:
    """Arguments that the docstring does not name, nor that of a function to which it leads."""
    function = getattr(pi, name)
    doc = inspect.getdoc(function) or ""
    left = {p for p in inspect.signature(function).parameters if not re.search(rf"\b{p}\b", doc)}
    other = re.search(r"[Tt]he others as in `(\w+)`", doc)
    return left & _unsaid(other[1]) | left - {*_arguments(other[1])} if other else left


def _arguments(name: str) -> list[str]:
    return list(inspect.signature(getattr(pi, name)).parameters)


@pytest.mark.parametrize("name", FUNCTIONS)
def test_a_function_names_its_arguments_and_its_errors(name):
    assert not _unsaid(name)
    assert re.search(r"Raises \w+Error", inspect.getdoc(getattr(pi, name)) or "")


def _public_functions(tree: ast.Module):
    for node in tree.body:
        inner = node.body if isinstance(node, ast.ClassDef) and not node.name.startswith("_") else [node]
        yield from (f for f in inner if isinstance(f, ast.FunctionDef) and not f.name.startswith("_"))


def _errors(function: ast.FunctionDef) -> set[str]:
    """Errors of ours that its own lines raise."""
    made = [n.exc for n in ast.walk(function) if isinstance(n, ast.Raise) and isinstance(n.exc, ast.Call)]
    return {ast.unparse(call.func) for call in made} - {"AssertionError", "NotImplementedError"}


def _shaped(function: ast.FunctionDef, doc: str) -> bool:
    types = ast.unparse(function.args) + ast.unparse(function.returns or ast.Constant(None))
    return "ndarray" not in types or bool(re.search(r"\(\w[^)]*\)|\(\.\.\.\)|\[[^\]]+\]", doc))


@pytest.mark.parametrize("root", sorted(ROOTS))
def test_every_public_function_says_what_it_is_and_what_it_raises(root):
    """Commands of the command line apart: an error of theirs is a sentence and an exit code.

    Functions of arrays give shapes, (N,), or units, [rad].
    """
    silent = []
    for file in sorted((PROJECT / root).rglob("*.py")):
        tree = ast.parse(file.read_text("utf-8"))
        for function in _public_functions(tree):
            doc = ast.get_docstring(function) or ""
            errors = {e for e in _errors(function) if e.endswith("Error") and "cli" not in file.parts}
            silent += [f"{file.name}: {function.name}: {e}" for e in errors if e not in doc]
            if function in tree.body and not (doc and _shaped(function, doc)):
                silent.append(f"{file.name}: {function.name}: shapes or units")
    assert not silent
