"""Checks of arguments. What is wrong is an ``InputError`` with one sentence that names the argument."""

from __future__ import annotations

import math
import operator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._errors import InputError

#: The largest whole number that the native part takes.
LARGEST = 2**64 - 1


def whole(name: str, given: Any, least: int = 0, most: int = LARGEST) -> int:
    """A whole number from ``least`` to ``most``, of Python or of numpy."""
    try:
        number = operator.index(given)
    except TypeError:
        raise InputError(f"{name} {given!r}: a whole number is needed") from None
    if not least <= number <= most:
        end = "2^64 − 1" if most == LARGEST else most
        raise InputError(f"{name} {number}: a whole number from {least} to {end} is needed")
    return number


def whole_or_none(name: str, given: Any, least: int = 0, most: int = LARGEST) -> int | None:
    """The same, where ``None`` is allowed."""
    return None if given is None else whole(name, given, least, most)


def magnitude_or_none(name: str, given: Any) -> float | None:
    """A finite number that is not negative, or ``None``."""
    if given is None:
        return None
    try:
        number = float(given)
    except (TypeError, ValueError):
        raise InputError(f"{name} {given!r}: a number is needed") from None
    if not 0 <= number < math.inf:
        raise InputError(f"{name} {number}: a finite number, 0 or more, is needed")
    return number


def numbers(name: str, given: Any) -> NDArray[np.float64]:
    """An array of numbers."""
    try:
        return np.asarray(given, dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError(f"{name}: an array of numbers is needed, with rows of equal length") from None


def points_of(name: str, given: Any) -> NDArray[np.float64]:
    """An array of points, shape (k, n)."""
    array = numbers(name, given)
    if array.ndim != 2:
        raise InputError(f"{name} has the shape {array.shape}, but (k, n) is needed")
    return array


def instance(name: str, given: object, kind: type) -> None:
    """Refuses what is not a ``kind``."""
    if not isinstance(given, kind):
        raise InputError(f"{name}: a landscape.{kind.__name__} is needed, not {type(given).__name__}")
