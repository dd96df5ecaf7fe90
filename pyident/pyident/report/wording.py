"""Numbers as an engineer reads them."""

from math import floor, isfinite, log10

_SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
MINUS = "−"


def number(value: float, digits: int = 3) -> str:
    """With so many significant digits, large and small ones by a power of ten."""
    if value == 0 or not isfinite(value):
        return "0" if value == 0 else "∞"
    exponent = floor(log10(abs(float(f"{value:.{digits - 1}e}"))))
    if exponent < -3 or exponent > 5:
        mantissa = f"{value / 10.0**exponent:.{digits - 1}f}"
        return f"{mantissa} × 10{str(exponent).translate(_SUPERSCRIPT)}".replace("-", MINUS)
    return _fixed(value, max(digits - 1 - exponent, 0))


def times(ratio: float) -> str:
    """A ratio to the floor."""
    return _fixed(ratio, 0 if ratio >= 99.95 else 1 if ratio >= 9.995 else 2)


def percent(share: float) -> str:
    """A share; what shows no digit is said to be small."""
    if 0 < share < 0.05:
        return "<\u00a00.1\u00a0%"
    return f"{_fixed(share, 0 if share >= 99.95 else 1)}\u00a0%"


def share(percentage: float) -> str:
    """Of an excess, of which nothing takes more than all: what leaves less than the floor takes 100 %."""
    return percent(min(percentage, 100.0))


def unit(symbol: str) -> str:
    """`N.m.s2/rad2` as N m s²/rad²; nothing for a pure number."""
    if symbol == "1":
        return ""
    spaced = symbol.replace(".", " ")
    return "".join(c.translate(_SUPERSCRIPT) if c.isdigit() else c for c in spaced)


def measured(value: float, std: float) -> str:
    """A value with as many digits as its standard deviation leaves it."""
    return _fixed(value, _places(std)) if _shown(value, std) else number(value, 4)


def _shown(value: float, std: float) -> bool:
    """Whether plain decimals show the value well."""
    return isfinite(std) and std > 0 and _places(std) <= 7 and max(abs(value), std) < 1e6


def _places(std: float) -> int:
    """Decimals that show two digits of a standard deviation."""
    return max(1 - floor(log10(std)), 0)


def _fixed(value: float, places: int) -> str:
    text = f"{abs(value):,.{places}f}".replace(",", "\u202f")
    return f"{MINUS}{text}" if value < 0 and any(c in "123456789" for c in text) else text
