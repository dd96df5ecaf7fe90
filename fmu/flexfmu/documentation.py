"""documentation/index.html: the equations and parameters of this very model."""

from jinja2 import Environment, PackageLoader

from flexfmu.variables import Variable, variables
from flexmodels.plant import Equations


def documentation(equations: Equations) -> str:
    """The page as text."""
    listed: list[Variable] = variables(equations)
    environment = Environment(loader=PackageLoader("flexfmu"), autoescape=True)
    return environment.get_template("index.html").render(eq=equations, listed=listed)
