"""Errors, all derived from one class. Each message says what was found, what was expected and what to do.

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
    """A mesh that is not a valid discretisation: inverted, degenerate or inconsistent elements."""


class SupportError(FecontactError):
    """A body can move freely under the loads; the message names the motion."""


class SolverError(FecontactError):
    """No certified solution of a complementarity problem was found; the message gives the status."""


class SolverNotFoundError(FecontactError, ValueError):
    """A solver or a back-end that is unknown or not installed; the message lists those that are."""


class MissingPackageError(FecontactError, ImportError):
    """An optional package that a feature needs is not installed; the message says how to install it."""
