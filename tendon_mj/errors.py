"""Errors of the package; a message names the cause, the value and the range or names allowed."""

from __future__ import annotations

import difflib
from collections.abc import Iterable


class TendonError(Exception):
    """Root of every error this package raises on purpose."""


class UnknownNameError(TendonError, ValueError):
    """A name that does not exist; the message lists the nearest and all valid ones."""

    def __init__(self, kind: str, name: str, valid: Iterable[str], where: str = "") -> None:
        super().__init__(f"{where + ': ' if where else ''}{unknown(kind, name, valid)}")


class UnknownKeyError(UnknownNameError, KeyError):
    """An unknown name as the key of a mapping, so that ``in`` and ``get`` work."""

    __str__ = Exception.__str__  # a KeyError would show the message in quotes


class UnknownAttributeError(UnknownNameError, AttributeError):
    """An unknown name as an attribute of an object, so that ``hasattr`` works."""


class InvalidValueError(TendonError, ValueError):
    """A value outside its range; the message names the parameter, the value and the range."""


class UnusedKeyError(InvalidValueError, KeyError):
    """A valid name used as a key where it has no effect; the message says why."""

    __str__ = Exception.__str__


class UnsuitedTendonError(InvalidValueError):
    """A tendon that cannot run in a sheath; a pattern skips it."""


class RecordingError(TendonError, ValueError):
    """A recording that cannot be read; the message names file, row and column."""


class EngineError(TendonError, RuntimeError):
    """The running MuJoCo does not fit the plugin, or cannot carry out a request."""


class NoPluginsError(EngineError, NotImplementedError):
    """Another engine than MuJoCo's, which runs no plugins."""


class WorkerError(TendonError, RuntimeError):
    """Workers that died, or one with other versions than this process."""


class MissingPackageError(TendonError, ModuleNotFoundError):
    """A package that is not installed; the message names its user and how to install it."""

    @classmethod
    def of_lab(cls, what: str, error: ModuleNotFoundError) -> MissingPackageError:
        """The error that ``what`` needs the extra `lab`; another one is raised as it is."""
        package = str(error.name).partition(".")[0]
        if package == "tendon_mj":
            raise error
        return cls(
            f"{what} needs {package}, which is not installed: pip install 'tendon-mj[lab]'",
            name=package,
        )


class TendonWarning(UserWarning):
    """A deviation from the expected; the message names it and the reason."""


def unknown(kind: str, name: str, valid: Iterable[str]) -> str:
    """Message that a ``kind`` of this name does not exist: the nearest valid name, and then all."""
    names = sorted(n for n in valid if n)
    near = difflib.get_close_matches(name, names, n=1, cutoff=0.5)
    hint = f"; did you mean {near[0]!r}?" if near else ""
    shown = ", ".join(repr(n) for n in names[:20]) + (", …" if len(names) > 20 else "")
    verb = "is" if len(names) == 1 else "are"
    return f"unknown {kind} {name!r}{hint} (there {verb}: {shown or 'none'})"
