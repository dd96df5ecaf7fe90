"""documentation/index.html: the equations and parameters of this very model."""

import hashlib
from typing import Any

from flexfmu.files.provenance import TOOL
from flexfmu.interface import Interface
from flexmodels.mechanics.plant import Equations


def plant_page(equations: Equations, interface: Interface, model: bytes | None) -> str:
    """The page of a plant, with or without its controller; `model`: content of the robot file."""
    digest = hashlib.sha256(model).hexdigest() if model is not None else None
    words = {"eq": equations, "interface": interface, "controller": equations.controller}
    return _page("index.html", digest=digest, **words)


def controller_page(equations: Equations, interface: Interface) -> str:
    """The page of a controller alone."""
    return _page("controller.html", interface=interface, controller=equations.controller)


def _page(template: str, **words: Any) -> str:
    from jinja2 import Environment, PackageLoader

    environment = Environment(loader=PackageLoader("flexfmu"), autoescape=True)
    return environment.get_template(template).render(tool=TOOL, **words)
