"""Registers the plugins of this package with the running MuJoCo."""

from __future__ import annotations

import ctypes
import functools
import re
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import mujoco

from tendon_mj.errors import EngineError
from tendon_mj.native import Library, load
from tendon_mj.plugin.abi.checks import CHECKS, Draft, asking
from tendon_mj.plugin.abi.layout import (
    LAYOUT,
    SCENE,
    read,
    verify,
    verify_scene,
    verify_state,
)
from tendon_mj.plugin.abi.library import PATH, C
from tendon_mj.plugin.elsewhere import guard_engines, register_pickles
from tendon_mj.plugin.servo_plugin import callbacks as _servo  # noqa: F401, whose functions the library has
from tendon_mj.plugin.servo_plugin import validate as servo_validate
from tendon_mj.plugin.servo_plugin.state import ATTRIBUTES as SERVO_ATTRIBUTES
from tendon_mj.plugin.sheath_plugin import callbacks as _sheath  # noqa: F401
from tendon_mj.plugin.sheath_plugin import validate
from tendon_mj.plugin.sheath_plugin.attributes import ATTRIBUTES

_ACTUATOR, _SENSOR, _PASSIVE = 1, 2, 4  # mjtPluginCapabilityBit


_FUNCTIONS = (
    "nstate nsensordata init destroy copy reset compute advance visualize actuator_act_dot"
    " sdf_distance sdf_gradient sdf_staticdistance sdf_attribute sdf_aabb"
)


class _Plugin(ctypes.Structure):
    """`mjpPlugin` of mjplugin.h."""

    _fields_ = (
        ("name", ctypes.c_char_p),
        ("nattribute", ctypes.c_int),
        ("attributes", ctypes.POINTER(ctypes.c_char_p)),
        ("capabilityflags", ctypes.c_int),
        ("needstage", ctypes.c_int),
        *((name, ctypes.c_void_p) for name in _FUNCTIONS.split()),
    )


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
    """Compare `_Plugin` with the header that MuJoCo ships.

    Raises:
        EngineError: the fields or their order differ.
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
    ours = [field[0] for field in _Plugin._fields_]
    if declared != ours:
        raise EngineError(
            f"mujoco {mujoco.__version__} declares mjpPlugin as {declared}, not as {ours}"
        )


class Definition(NamedTuple):
    """Definition of a plugin.

    Attributes:
        name: in MJCF.
        symbol: of its functions in the library, between ``tendon_mj_`` and the name of each.
        attributes: of its configuration.
        capabilities: sum of `mjtPluginCapabilityBit`.
        functions: of `mjpPlugin`, that the library has.
        state_size: checks an instance, returns its numbers of state, ≥ 1.
        complete: checks an instance once the model is complete.
        sensor_size: numbers of a sensor.
    """

    name: str
    symbol: str
    attributes: tuple[str, ...]
    capabilities: int
    functions: str
    state_size: Callable[[int, int], int]
    complete: Callable[[int, int], int]
    sensor_size: Callable[[int, int, int], int] | None = None


DEFINITIONS = (
    Definition(
        validate.NAME,
        "sheath",
        ATTRIBUTES,
        _ACTUATOR | _SENSOR | _PASSIVE,
        "nstate nsensordata init reset compute advance visualize",
        validate.state_size,
        validate.check_tendon,
        validate.reading_size,
    ),
    Definition(
        servo_validate.SERVO,
        "servo",
        SERVO_ATTRIBUTES,
        _ACTUATOR,
        "nstate init reset compute advance",
        servo_validate.state_size,
        servo_validate.check_joint,
    ),
)

NAMES = tuple(definition.name for definition in DEFINITIONS)

# Not stepped: MuJoCo hands the plugin its state directly, before the offsets are verified.
_SMALLEST = f"""
<mujoco>
  <extension>
    <plugin plugin="{validate.NAME}">
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


def _raise_refusals(model: Draft) -> None:
    """Raise the first refusal of those that were a state of size 0."""
    sizes = {definition.name: definition.state_size for definition in DEFINITIONS}
    for k in filter(model.is_refused, range(model.fields.nplugin)):
        if model.plugin(k) in sizes:
            sizes[model.plugin(k)](model.address, k)
            raise EngineError(f"{model.where(k)}: refused at first, and then not")


def _complete(plugin: Definition) -> Callable[[int, int], int]:
    """The check of `init`, after the refusals of `nstate`."""

    @functools.wraps(plugin.complete)
    def complete(address: int, instance: int) -> int:
        model = Draft(address, ())
        if model.first(instance) == instance:
            _raise_refusals(model)
        return plugin.complete(address, instance)

    return complete


_registered: list[object] = []  # C holds pointers to these, so they are never freed


def _register(plugin: Definition, library: Library) -> None:
    names = (ctypes.c_char_p * len(plugin.attributes))(*(a.encode() for a in plugin.attributes))
    struct = _Plugin(
        name=plugin.name.encode(),
        nattribute=len(plugin.attributes),
        attributes=names,
        capabilityflags=plugin.capabilities,
        needstage=mujoco.mjtStage.mjSTAGE_ACC.value,
        **{k: library.address(f"tendon_mj_{plugin.symbol}_{k}") for k in plugin.functions.split()},
    )
    _registered.extend([names, struct])
    if C.mjp_registerPlugin(ctypes.byref(struct)) < 0:
        raise EngineError(f"{PATH.name} refused the plugin {plugin.name}")


def _set_checks(library: Library) -> None:
    """Let the library ask Python when MuJoCo compiles a model."""
    addresses = library.numbers("tendon_mj_checks", len(CHECKS))
    for plugin in DEFINITIONS:
        asked = {
            f"{plugin.symbol}_nstate": asking(plugin.name, plugin.state_size),
            f"{plugin.symbol}_init": asking(plugin.name, _complete(plugin), data=True),
        }
        if plugin.sensor_size:
            asked[f"{plugin.symbol}_nsensordata"] = asking(plugin.name, plugin.sensor_size, 2)
        for check, function in asked.items():
            addresses[CHECKS.index(check)] = ctypes.cast(function, ctypes.c_void_p).value or 0
            _registered.append(function)


def _set_layout(library: Library) -> dict[str, int]:
    """Give the library the offsets of the running MuJoCo, once they are verified."""
    layout, scene = read(LAYOUT), read(SCENE)
    verify(layout)
    verify_scene(scene)
    for constants, offsets in ((LAYOUT, layout), (SCENE, scene)):
        library.numbers(constants.symbol, len(offsets))[:] = list(offsets.values())
    return layout


def register() -> tuple[str, ...]:
    """Make the plugins known to MuJoCo; a second call does nothing more.

    Returns:
        Their names.

    Raises:
        EngineError: the running MuJoCo does not have the layout that the plugins would read.
    """
    if not _registered:
        _verify_version()
        _verify_struct()
        library = load()
        layout = _set_layout(library)
        _set_checks(library)
        for definition in DEFINITIONS:
            _register(definition, library)
        register_pickles(NAMES)
        guard_engines(NAMES)
        verify_state(layout, mujoco.MjData(mujoco.MjModel.from_xml_string(_SMALLEST)))
    return NAMES
