"""Exceptions of this package. Errors of the operating system are ``OSError`` (``FileNotFoundError``, ``PermissionError``)."""

from __future__ import annotations


class LandscapeError(Exception):
    """An error of this package. Its text is one sentence, the same as that of the command line."""


class InputError(LandscapeError, ValueError):
    """Something given is wrong: a file, a number, a shape, a name."""


class EnergyError(LandscapeError, ValueError):
    """A function given as an energy returned what is no energy: NaN, a wrong shape, a wrong type."""

    x: list[float]
    """The point at which the function was called."""


class GradientError(EnergyError):
    """The gradient of a function given as an energy is not the derivative of its energy."""

    component: int
    """The component that is wrong, from 0."""
    given: float
    """This component as the function gives it."""
    measured: float
    """This component from differences of the energy."""


class NothingFoundError(LandscapeError, RuntimeError):
    """A search found no minimum, or a map found nothing to connect."""


class InternalError(LandscapeError, RuntimeError):
    """An error of this package itself. Please report it."""
