"""Numbers as a reader wants them: with their uncertainty and unit, chances and odds."""

from __future__ import annotations

import math

_LEAST_P = 1e-300
_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_UNCERTAINTY_FIGURES = 2
_CLOSE = ("", "°", "′", "″")


def with_uncertainty(value: float, sigma: float | None, unit: str) -> str:
    """A value with as many decimals as its standard deviation leaves meaning."""
    if sigma is None or not math.isfinite(sigma) or sigma <= 0.0:
        return minus(joined(f"{value:.4g}", unit))
    decimals = min(max(_UNCERTAINTY_FIGURES - 1 - math.floor(math.log10(sigma)), 0), 6)
    number = minus(f"{value:.{decimals}f}")
    if unit in _CLOSE:
        return f"{number}{unit} ± {sigma:.{decimals}f}{unit}"
    return f"{number} ± {sigma:.{decimals}f} {unit}".strip()


def joined(number: str, unit: str) -> str:
    """A number with its unit; signs of angles stand close."""
    return f"{number}{unit}" if unit in _CLOSE else f"{number} {unit}"


def odds(evidence: float) -> str:
    """ln of odds in words."""
    if evidence < 0.0:
        return minus(f"e^{evidence:.0f} : 1")
    return f"e^{evidence:,.0f} : 1"


def p_in_words(p: float) -> str:
    """A p-value as it is printed; what underflows is an upper bound."""
    if p < _LEAST_P:
        return "p below 10⁻³⁰⁰"
    if p >= 1e-3:
        return f"p = {p:.2g}"
    digits, power = f"{p:.1e}".split("e")
    return f"p = {digits}·10{str(int(power)).translate(_RAISED)}"


def minus(number: str) -> str:
    """The number with a true minus sign."""
    return number.replace("-", "−")
