"""Names: of parameters in FMI, of the binary, and as text in C."""

import hashlib
import re

_AXES = {"x": "1", "y": "2", "z": "3"}
_LONGEST = 64  # characters of an identifier, before its hash
# Names of devices on Windows, which no file may carry there.
_RESERVED = {"CON", "PRN", "AUX", "NUL", *(f"{port}{i}" for port in ("COM", "LPT") for i in range(10))}


def fmi_name(parameter: str) -> str:
    """FMI's structured name of a parameter: link1.ms[x] -> link1.ms[1], link1.J[xy] -> link1.J[1,2]."""
    return re.sub(r"\[([xyz]+)\]", lambda m: f"[{','.join(_AXES[a] for a in m[1])}]", parameter)


def c_identifier(name: str) -> str:
    """A C identifier for any name: short ASCII; a hash keeps changed ones distinct."""
    plain = re.sub(r"[^A-Za-z0-9_]", "_", name)[:_LONGEST]
    if plain == name and re.match(r"[A-Za-z]", name) and name.upper() not in _RESERVED:
        return name
    digest = hashlib.sha256(name.encode("utf-8", "surrogatepass")).hexdigest()[:8]
    return (
        f"{plain.strip('_') or 'model'}_{digest}" if re.match(r"[A-Za-z]", plain) else f"m_{plain}_{digest}"
    )


def c_string(text: str) -> str:
    """A C string literal: ASCII letters as they are, every other byte of the UTF-8 in octal."""
    plain = {*map(ord, "_[](),.+-*/=<>:; "), *range(48, 58), *range(65, 91), *range(97, 123)}
    data = text.encode("utf-8", "surrogatepass")
    return '"' + "".join(chr(b) if b in plain else f"\\{b:03o}" for b in data) + '"'
