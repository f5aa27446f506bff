"""The library and a header, for programs in C, C++ and whatever loads MuJoCo's plugins."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path

from tendon_mj.errors import EngineError
from tendon_mj.native import load
from tendon_mj.plugin.force_servo_plugin import GAINS, SERVO
from tendon_mj.plugin.sheath_plugin import ATTACHMENT, KINDS, NAME, PARAMETERS
from tendon_mj.sheath import Parameter
from tendon_mj.whole_file import whole_file

_HEADER = """\
// Attributes of the plugins in {library}, for <config key="…" value="…"/> in MJCF and for
// mjs_setPluginAttributes. mj_loadPluginLibrary loads the library, which registers its plugins.

#ifndef TENDON_MJ_H_
#define TENDON_MJ_H_

#define TENDON_MJ_SHEATH "{sheath}"
#define TENDON_MJ_SERVO "{servo}"

static const char* const tendon_mj_sheath_attributes[] = {{
{sheath_attributes}
}};

// values of the attribute "sensor"
static const char* const tendon_mj_sensors[] = {{
{sensors}
}};

static const char* const tendon_mj_servo_attributes[] = {{
{servo_attributes}
}};

#endif  // TENDON_MJ_H_
"""
_SERVO_WORDS = {
    "tendon": "tendon that the motor winds, which runs in a sheath",
    "feedback": "`sensor` or `observer`",
    "backdrive": "`true` where the tendon can turn the motor",
    "instance": "no meaning now; earlier releases wrote it",
}


def _lines(described: Iterable[tuple[str, str]]) -> str:
    return "\n".join(f'  "{name}",  // {text}' for name, text in described)


def _parameters(parameters: Mapping[str, Parameter]) -> list[tuple[str, str]]:
    return [(name, f"{p.line()[:-1]}, {p.range}") for name, p in parameters.items()]


def export_library(folder: str | Path) -> Path:
    """Write the library and the header `tendon_mj.h` into a folder.

    Returns:
        The path of the library.

    Raises:
        EngineError: there is only an object file, as no C compiler was found.
    """
    source = load().path
    if source.suffix == ".o":
        raise EngineError(f"{source} is not linked: install a C compiler, delete it and try again")
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    library = folder / f"libtendon_mj{source.suffix}"
    with whole_file(library) as file:  # programs may have the one before loaded
        file.write_bytes(source.read_bytes())
    attachment = [(name, a.text) for name, a in ATTACHMENT.items()]
    header = _HEADER.format(
        library=library.name,
        sheath=NAME,
        servo=SERVO,
        sheath_attributes=_lines([*attachment, *_parameters(PARAMETERS)]),
        sensors=_lines((kind, f"{text} [{unit}]") for kind, (text, unit, _) in KINDS.items()),
        servo_attributes=_lines([*_parameters(GAINS), *_SERVO_WORDS.items()]),
    )
    with whole_file(folder / "tendon_mj.h") as file:
        file.write_text(header, "utf-8")
    return library
