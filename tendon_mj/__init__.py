"""Tendon-sheath friction for MuJoCo.

Importing this package registers the engine plugins `tendon_mj.sheath` and `tendon_mj.servo`, so
that models which use them can be loaded. The public interface is in `__init__.pyi`; a name of it is
loaded when it is first used. Those of the laboratory need the extra `lab`.
"""

import ast
from importlib import import_module
from pathlib import Path
from typing import Any

from tendon_mj import lab
from tendon_mj.errors import MissingPackageError
from tendon_mj.plugin import register

_PACKAGES = {  # of the public names
    alias.name: node.module
    for node in ast.parse(Path(__file__).with_suffix(".pyi").read_text("utf-8")).body
    if isinstance(node, ast.ImportFrom) and node.module
    for alias in node.names
}
__all__ = sorted([*_PACKAGES, "__version__"])


def __getattr__(name: str) -> Any:
    """Load a name of the public interface when it is first used.

    Raises:
        MissingPackageError: it needs the extra `lab`, which is not installed.
    """
    if name == "__version__":
        value: Any = _version()
    elif name in _PACKAGES:
        try:
            value = getattr(import_module(_PACKAGES[name]), name)
        except ModuleNotFoundError as error:
            raise MissingPackageError.of_lab(f"tendon_mj.{name}", error) from None
    else:
        raise AttributeError(f"module 'tendon_mj' has no attribute {name!r}")
    globals()[name] = value
    return value


def _version() -> str:
    """Version of the installed package, "unknown" if its sources are used without installing."""
    metadata = import_module("importlib.metadata")  # takes time to load
    try:
        return str(metadata.version("tendon-mj"))
    except metadata.PackageNotFoundError:
        return "unknown"


def __dir__() -> list[str]:
    return __all__


def _first_screen(diagnosis: Any) -> str:
    return str(import_module("tendon_mj.show").first_screen(diagnosis))


lab.renderers["diagnosis"] = _first_screen
register()
