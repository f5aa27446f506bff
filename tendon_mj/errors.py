"""Errors of the package; a message names the cause, the value and the range or names allowed."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import SequenceMatcher
from typing import Final

INTERRUPTED: Final = "interrupted while the model was compiled"  # text of MuJoCo's ValueError
_ALIKE = 0.6  # least similarity of a name that is suggested
_SHOWN = 5  # names that a message lists
_SYMBOLS: Final = {  # symbol of a quantity → its name in a model
    **dict.fromkeys(("mu", "μ", "µ"), "friction"),
    "ea": "axial_stiffness",
    **dict.fromkeys(("t_0", "t0"), "pretension"),
}
_LISTS: Final = {  # kind → command or name that lists all of it
    "command": "`tendon-mj --help`",
    "effect": "`tendon_mj.CATALOGUE`",
    "parameter": "`tendon-mj parameters MODEL`",
}


class TendonError(Exception):
    """Root of every error this package raises on purpose."""


class UnknownNameError(TendonError, ValueError):
    """A name that does not exist; the message lists those that are most alike."""

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
    """Message that a ``kind`` of this name does not exist, with a `suggestion`."""
    return f"unknown {kind} {name!r}{suggestion(kind, name, valid)}"


def suggestion(kind: str, name: str, valid: Iterable[str], folder: str = "") -> str:
    """End of a message: the name that is meant if one is, five that are alike, how to list all.

    The one that is meant has ``folder`` before it, and can be copied.
    """
    names = sorted(n for n in valid if n)
    front, dot, last = name.rpartition(".")
    meant = front + dot + _SYMBOLS.get(last.casefold(), last)
    ranked = sorted(names, key=lambda v: (not _begins(meant, v), -sum(_likeness(meant, v))))
    alike = (n for n in ranked if _begins(meant, n) or min(_likeness(meant, n)) >= _ALIKE)
    near = next(alike, "")
    hint = f"; did you mean {folder + near!r}?" if near else ""
    listed, more = names, ""
    if len(names) > _SHOWN:
        listed, more = ranked[:_SHOWN], ", …"
        more += f"; {_LISTS[kind]} lists all" if kind in _LISTS else ""
    shown = ", ".join(map(repr, listed)) + more
    verb = "is" if len(names) == 1 else "are"
    return f"{hint} (there {verb}: {shown or 'none'})"


def _begins(name: str, valid: str) -> bool:
    """Return whether a name is the beginning of a valid one, three letters of it at least."""
    return len(name) >= 3 and valid.casefold().startswith(name.casefold())


def _likeness(name: str, valid: str) -> list[float]:
    """Likeness of each part from the last: `flexor.mu` is not like `flexor.lag`.

    A single letter is like itself only.
    """
    parts = name.split(".")[::-1], valid.split(".")[::-1]
    pairs = zip(*parts, strict=False) if len(parts[0]) <= len(parts[1]) else [(name, valid)]
    ratios = ((a, b, SequenceMatcher(None, a, b).ratio()) for a, b in pairs)
    return [ratio if a == b or min(len(a), len(b)) > 1 else 0.0 for a, b, ratio in ratios]
