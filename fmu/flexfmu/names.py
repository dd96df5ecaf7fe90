"""Names of parameters: public ones and those of FMI."""

import re

_AXES = {"x": "1", "y": "2", "z": "3"}


def fmi_name(parameter: str) -> str:
    """FMI's structured name of a parameter: link1.ms[x] -> link1.ms[1], link1.J[xy] -> link1.J[1,2]."""
    return re.sub(r"\[([xyz]+)\]", lambda m: f"[{','.join(_AXES[a] for a in m[1])}]", parameter)
