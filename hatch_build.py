"""Puts the library of compiled functions into a wheel, built for the machine that builds it."""

import sys
import sysconfig
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


class LibraryHook(BuildHookInterface):  # type: ignore[type-arg]
    """Hook of hatchling; an editable install builds its library at the first import."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Build the library unless it is there, and add it to the wheel."""
        if version == "editable":
            return
        sys.path.insert(0, self.root)
        from tendon_mj.native import FOLDER, load

        library = load().path
        if library.suffix == ".o":
            raise RuntimeError("a wheel needs a C compiler, which links its library")
        inside = Path("tendon_mj") / FOLDER.relative_to(Path(self.root, "tendon_mj")) / library.name
        build_data["force_include"][str(library)] = inside.as_posix()
        build_data["pure_python"] = False
        platform = sysconfig.get_platform().replace("-", "_").replace(".", "_")
        build_data["tag"] = f"py3-none-{platform}"  # it has nothing of Python's
