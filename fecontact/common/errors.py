"""Errors: one root, and every message says what was found, what was expected and what to do.

Examples
--------
>>> from fecontact.common.errors import FecontactError, InputError
>>> issubclass(InputError, FecontactError)
True
"""


class FecontactError(Exception):
    """Root of all errors that fecontact raises on purpose."""


class InputError(FecontactError, ValueError):
    """A number, a name or an option that cannot be used; nothing has been computed yet."""


class MeshError(FecontactError, ValueError):
    """A mesh that is not a valid cut of a body: inverted, degenerate beyond repair, or inconsistent."""


class SupportError(FecontactError):
    """A body can move without resistance where the loads push it; the message names the motion."""


class SolverError(FecontactError):
    """A complementarity problem for which no certified answer was found; the message tells the status."""


class SolverNotFoundError(FecontactError, ValueError):
    """A solver or a back-end that is unknown or not installed; the message lists those that are."""


class MissingPackageError(FecontactError, ImportError):
    """An optional package that a feature needs and that is not installed; the message names the remedy."""
