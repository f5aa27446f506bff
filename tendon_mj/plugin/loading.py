"""Loading of the library in Python: the offsets of the running MuJoCo, and checks in Python."""

from __future__ import annotations

import ctypes
import functools
import re
from pathlib import Path

import mujoco

from tendon_mj.errors import EngineError
from tendon_mj.native import ENGINE, ENGINE_ARRAY, Library, load
from tendon_mj.plugin import registration  # with all that the library has
from tendon_mj.plugin.abi import LAYOUT, SCENE, C, read, verify, verify_scene, verify_state
from tendon_mj.plugin.advice import write_advice
from tendon_mj.plugin.compiled_checks import ADVICE
from tendon_mj.plugin.force_servo_plugin import SERVO
from tendon_mj.plugin.pickles import register_pickles
from tendon_mj.plugin.sheath_plugin import NAME

_OLDEST = (3, 11)  # MuJoCo, the first with several outputs of an actuator


def _verify_version() -> None:
    """Refuse a MuJoCo before the oldest that the plugins can run in.

    Raises:
        EngineError: names both.
    """
    if tuple(int(part) for part in mujoco.__version__.split(".")[:2]) < _OLDEST:
        oldest = ".".join(map(str, _OLDEST))
        raise EngineError(
            f"mujoco {mujoco.__version__} is older than {oldest}, the oldest with which tendon-mj "
            f'works: pip install "mujoco>={oldest}"'
        )


def _verify_struct() -> None:
    """Compare the members of `mjpPlugin` with the header that MuJoCo ships.

    Raises:
        EngineError: they or their order differ.
    """
    header = Path(mujoco.__file__).parent / "include" / "mujoco" / "mjplugin.h"
    if not header.exists():
        raise EngineError(f"{header} is missing, so the plugin's structure cannot be checked")
    body = re.search(r"typedef struct mjpPlugin_ \{(.*?)\} mjpPlugin;", header.read_text(), re.S)
    code = re.sub(r"//[^\n]*", "", body.group(1)) if body else ""
    declared = [
        re.sub(r"\(\*(\w+)\)\(.*", r"\1", part.strip(), flags=re.S).split()[-1].strip("*")
        for part in code.split(";")
        if part.strip()
    ]
    expected = registration.MEMBERS.split()
    if declared != expected:
        raise EngineError(
            f"mujoco {mujoco.__version__} declares mjpPlugin as {declared}, not as {expected}"
        )


NAMES = (NAME, SERVO)

# Not stepped: MuJoCo hands the plugin its state directly, before the offsets are verified.
_SMALLEST = f"""
<mujoco>
  <extension>
    <plugin plugin="{NAME}">
      <instance name="sheath">
        <config key="tendon" value="t"/>
        <config key="friction" value="0"/>
        <config key="axial_stiffness" value="1"/>
      </instance>
    </plugin>
  </extension>
  <worldbody><site name="a"/><site name="b" pos="1 0 0"/></worldbody>
  <tendon><spatial name="t"><site site="a"/><site site="b"/></spatial></tendon>
</mujoco>
"""


def _set_functions(library: Library) -> None:
    """Tell the library where MuJoCo's functions are."""
    addresses = library.numbers(ENGINE_ARRAY, len(ENGINE))
    addresses[:] = [ctypes.cast(getattr(C, name), ctypes.c_void_p).value for name in ENGINE]


def _verify_registered(library: Library) -> None:
    """Refuse plugins of another copy of the library, which asks no checks in Python.

    Raises:
        EngineError: the program has loaded one before.
    """
    struct = C.mjp_getPlugin(NAMES[0].encode(), ctypes.byref(ctypes.c_int()))
    nstate = ctypes.c_void_p.from_address(struct + 8 * registration.NSTATE).value
    if nstate != library.address("tendon_mj_sheath_nstate"):
        raise EngineError(
            f"another copy of the library has registered the plugin {NAMES[0]}: import tendon_mj "
            "before mj_loadPluginLibrary loads it, or not at all"
        )


def _set_layout(library: Library) -> dict[str, int]:
    """Give the library the offsets of the running MuJoCo, once they are verified."""
    layout, scene = read(LAYOUT), read(SCENE)
    verify(layout)
    verify_scene(scene)
    for constants, offsets in ((LAYOUT, layout), (SCENE, scene)):
        library.numbers(constants.symbol, len(offsets))[:] = list(offsets.values())
    return layout


@functools.cache
def register() -> tuple[str, ...]:
    """Make the plugins known to MuJoCo; a second call does nothing more.

    Returns:
        Their names.

    Raises:
        EngineError: the running MuJoCo does not have the layout that the plugins would read.
    """
    _verify_version()
    _verify_struct()
    library = load()
    _set_functions(library)
    layout = _set_layout(library)
    library.numbers(ADVICE, 1)[0] = ctypes.cast(write_advice, ctypes.c_void_p).value
    ctypes.CFUNCTYPE(None)(library.address("tendon_mj_register"))()
    _verify_registered(library)
    register_pickles(NAMES)
    verify_state(layout, mujoco.MjData(mujoco.MjModel.from_xml_string(_SMALLEST)))
    return NAMES
