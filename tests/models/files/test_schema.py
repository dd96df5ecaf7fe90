"""The published JSON Schema against the reader of robot files: both accept and refuse the same tables."""

import copy
import json
import tomllib

import pytest
import tomli_w
from click.testing import CliRunner

from flexmodels.files.robot_file import load_robot, shipped
from flexmodels.files.schema import schema
from flexmodels.robot import RobotError
from pyident.cli.main import main

jsonschema = pytest.importorskip("jsonschema")


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
    """One thing wrong at a time: (what, table)."""

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

    yield "an unknown key", changed("colour", value="red")
    yield "an unknown key of a joint", changed("joint", 0, "colour", value="red")
    yield "an unknown effect", changed("joint", 0, "effects", value={"magic": {}})
    yield "an unknown parameter", changed("joint", 0, "effects", value={"stribeck": {"magic": 1.0}})
    yield "a negative level", changed("joint", 0, "coulomb", value=-1.0)
    yield "a word for a number", changed("joint", 0, "coulomb", value="much")
    yield "an axis of two numbers", changed("joint", 0, "x", value=[1.0, 0.0])
    yield "no axis", changed("joint", 0, "x", value=None)
    yield "no links", changed("link", value=None)
    yield "a negative mass", changed("link", 0, "m", value=-1.0)
    yield "a controller without rate", changed("controller", "rate", value=None)
    yield "a kind of its own", changed("joint", 0, "kind", value="ball")


def test_what_the_schema_refuses_the_reader_refuses_too(validator, tmp_path):
    data = tomllib.loads(shipped()["four_link"].read_text(encoding="utf-8"))
    for what, table in _wrong(data):
        assert not validator.is_valid(table), what
        (tmp_path / "wrong.toml").write_text(tomli_w.dumps(table))
        with pytest.raises(RobotError):
            load_robot(tmp_path / "wrong.toml")


def test_every_effect_is_explained():
    joint = schema()["properties"]["joint"]["items"]["anyOf"][0]["properties"]
    effects = joint["effects"]["properties"]
    assert "Stribeck friction" in effects["stribeck"]["description"]
    assert effects["stribeck"]["properties"]["level"]["minimum"] == 0


def test_the_command_writes_it(tmp_path):
    file = tmp_path / "robot.schema.json"
    assert CliRunner().invoke(main, ["robots", "schema", "-o", str(file)]).exit_code == 0
    assert json.loads(file.read_text()) == schema()
