"""The published JSON Schema against the reader of robot files: both accept and refuse the same tables."""

import copy
import json
import re
import tomllib
from importlib import resources

import jsonschema
import pytest
import tomli_w
from click.testing import CliRunner

from flexmodels.files.robot_file import load_robot, shipped
from flexmodels.files.schema import schema
from flexmodels.files.toml_table import Table
from flexmodels.robot import RobotError
from pyident.cli.main import main


@pytest.fixture(scope="module")
def validator():
    jsonschema.Draft202012Validator.check_schema(schema())
    return jsonschema.Draft202012Validator(schema())


@pytest.mark.parametrize("name", shipped())
def test_shipped_robots_are_valid(validator, name):
    table = tomllib.loads(shipped()[name].read_text(encoding="utf-8"))
    assert [error.json_path for error in validator.iter_errors(table)] == []
    table["joint"][-1]["x"] = [1.0, 0.0]  # what is far down in the file is looked at, too
    assert [e.json_path for e in validator.iter_errors(table)] == [f"$.joint[{len(table['joint']) - 1}]"]


def _wrong(data: dict):
    """One thing wrong at a time: (what a reader is told of it, table)."""

    def changed(*path, value):
        new = copy.deepcopy(data)
        table = new
        for key in path[:-1]:
            table = table[key]
        if value is None:
            del table[path[-1]]
        else:
            table[path[-1]] = value
        return new

    first = ("joint", 0)
    yield "colour is not a known key", changed("colour", value="red")
    yield "joint[1].colour is not a known key", changed(*first, "colour", value="red")
    yield (
        "joint[1].effects.magic is not a known effect; known are",
        changed(*first, "effects", value={"magic": {}}),
    )
    magic = {"stribeck": {"magic": 1.0}}
    yield "joint[1].effects.stribeck.magic is not a known key", changed(*first, "effects", value=magic)
    yield "joint[1].coulomb = -1.0 must be at least 0", changed(*first, "coulomb", value=-1.0)
    yield "joint[1].coulomb must be a finite number, not 'much'", changed(*first, "coulomb", value="much")
    yield "joint[1].k must be a list of numbers", changed(*first, "k", value="stiff")
    yield "joint[1].x must be 3 numbers", changed(*first, "x", value=[1.0, 0.0])
    yield "joint[1].x is missing", changed(*first, "x", value=None)
    yield "joint[1].kind must be revolute or prismatic, not 'ball'", changed(*first, "kind", value="ball")
    yield "joint[1].parent must be a whole number, not 0.5", changed(*first, "parent", value=0.5)
    yield "joint[1].passive must be true or false, not 'no'", changed(*first, "passive", value="no")
    yield "joint must be a list of tables ([[joint]])", changed("joint", value={"x": 1})
    yield "link is missing", changed("link", value=None)
    yield "link[1].m = -1.0 must be at least 0", changed("link", 0, "m", value=-1.0)
    yield (
        "link[1].J_com[2] must be a finite number, not 'b'",
        changed("link", 0, "J_com", value=[1.0, "b", 1.0]),
    )
    yield "link[1].m is missing", changed("link", 0, "m", value=None)
    yield "controller.rate is missing", changed("controller", "rate", value=None)
    yield "controller.rate = 0 must be at least 0.001", changed("controller", "rate", value=0)
    yield "controller must be a table", changed("controller", value=3)
    yield "identification.period = 0.0 must be above 0", changed("identification", "period", value=0.0)
    yield "processing.order = 99 must be at most 20", changed("processing", value={"order": 99})
    ratio = {"ratio": [[1.0, 0.0], [0.0, "b"]]}
    yield "transmission.ratio[2][2] must be a finite number, not 'b'", changed("transmission", value=ratio)
    yield "columns.time must be a text or a table, not 3", changed("columns", value={"time": 3})


def test_what_the_schema_refuses_the_reader_refuses_in_one_sentence(validator, tmp_path):
    data = tomllib.loads(shipped()["four_link"].read_text(encoding="utf-8"))
    for told, table in _wrong(data):
        assert not validator.is_valid(table), told
        (tmp_path / "wrong.toml").write_text(tomli_w.dumps(table))
        with pytest.raises(RobotError) as caught:
            load_robot(tmp_path / "wrong.toml")
        assert str(caught.value).startswith(f"{tmp_path / 'wrong.toml'}: {told}"), told
        assert "\n" not in str(caught.value)


def test_the_reader_has_no_keys_of_its_own(monkeypatch):
    """Every key that it asks a shipped robot's tables for, the schema has at that place."""
    asked: dict[str, set[str]] = {}
    for method in ("__contains__", "get"):
        original = getattr(Table, method)

        def spied(self, key, *rest, original=original):
            asked.setdefault(re.sub(r"\[\d+\]", "", self.where), set()).add(key)
            return original(self, key, *rest)

        monkeypatch.setattr(Table, method, spied)
    for name in shipped():
        load_robot(name)
    for place in ("", "controller", "transmission", "processing", "identification", "line", "closure"):
        properties = schema()["properties"]
        table = properties[place] if place else schema()
        table = table.get("items", table)
        assert asked.pop(place) <= set(table["properties"]), place
    for place in ("joint", "link"):
        forms = schema()["properties"][place]["items"]["anyOf"]
        assert asked.pop(place) <= set().union(*(form["properties"] for form in forms)), place


def test_the_shipped_schema_is_this_one():
    """`pyident robots schema -o models/flexmodels/robot.schema.json` writes it anew."""
    text = (resources.files("flexmodels") / "robot.schema.json").read_text(encoding="utf-8")
    assert json.loads(text) == schema()


def test_every_effect_is_explained():
    joint = schema()["properties"]["joint"]["items"]["anyOf"][0]["properties"]
    effects = joint["effects"]["properties"]
    assert "Stribeck friction" in effects["stribeck"]["description"]
    assert effects["stribeck"]["properties"]["level"]["minimum"] == 0


def test_the_command_writes_it(tmp_path):
    file = tmp_path / "robot.schema.json"
    assert CliRunner().invoke(main, ["robots", "schema", "-o", str(file)]).exit_code == 0
    assert json.loads(file.read_text()) == schema()
