"""A wheel takes the studies along; an editable install finds them where they are."""

from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface  # pyright: ignore


class Studies(BuildHookInterface):
    """Puts studies/ into the wheel as pyident/_studies."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        if version == "standard":
            build_data["force_include"]["studies"] = "pyident/_studies"
