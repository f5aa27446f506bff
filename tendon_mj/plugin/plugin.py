"""Registers the plugins of this package with the running MuJoCo."""

from __future__ import annotations

import ctypes
import functools
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import mujoco

from tendon_mj.compilation import announced
from tendon_mj.errors import EngineError
from tendon_mj.plugin.abi.checks import Check, Draft
from tendon_mj.plugin.abi.layout import (
    Layout,
    SceneLayout,
    read_layout,
    read_scene_layout,
    verify,
    verify_scene,
    verify_state,
)
from tendon_mj.plugin.abi.library import PATH, C
from tendon_mj.plugin.elsewhere import guard_engines, register_pickles
from tendon_mj.plugin.servo_plugin import callbacks as servo_callbacks
from tendon_mj.plugin.servo_plugin import validate as servo_validate
from tendon_mj.plugin.servo_plugin.state import ATTRIBUTES as SERVO_ATTRIBUTES
from tendon_mj.plugin.sheath_plugin import validate
from tendon_mj.plugin.sheath_plugin.attributes import ATTRIBUTES
from tendon_mj.plugin.sheath_plugin.callbacks import Callbacks, make_callbacks
from tendon_mj.plugin.sheath_plugin.visualize import make_visualize

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
    """Definition of a plugin."""

    name: str  # in MJCF
    attributes: tuple[str, ...]  # of its configuration
    capabilities: int  # sum of `mjtPluginCapabilityBit`
    state_size: Callable[[int, int], int]  # checks an instance, returns its numbers of state, ≥ 1
    complete: Callable[[int, int], int]  # checks an instance once the model is complete
    callbacks: Callable[[Layout], Callbacks]  # makes the functions that run in a step
    sensor_size: Callable[[int, int, int], int] | None = None  # numbers of a sensor
    visualize: Callable[[Layout, SceneLayout], Any] | None = None  # makes the function that draws


DEFINITIONS = (
    Definition(
        validate.NAME,
        ATTRIBUTES,
        _ACTUATOR | _SENSOR | _PASSIVE,
        validate.state_size,
        validate.check_tendon,
        make_callbacks,
        validate.reading_size,
        make_visualize,
    ),
    Definition(
        servo_validate.SERVO,
        SERVO_ATTRIBUTES,
        _ACTUATOR,
        servo_validate.state_size,
        servo_validate.check_joint,
        servo_callbacks.make_callbacks,
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


def _register(plugin: Definition, layout: Layout, scene_layout: SceneLayout) -> None:
    callbacks = plugin.callbacks(layout)
    visualize = plugin.visualize(layout, scene_layout) if plugin.visualize else None
    nstate = Check(plugin.name, plugin.state_size)
    init = Check(plugin.name, _complete(plugin), data=True)
    sensor = Check(plugin.name, plugin.sensor_size, 2) if plugin.sensor_size else None
    names = (ctypes.c_char_p * len(plugin.attributes))(*(a.encode() for a in plugin.attributes))
    struct = _Plugin(
        name=plugin.name.encode(),
        nattribute=len(plugin.attributes),
        attributes=names,
        capabilityflags=plugin.capabilities,
        needstage=mujoco.mjtStage.mjSTAGE_ACC.value,
        nstate=nstate.address,
        nsensordata=sensor.address if sensor else None,
        init=init.address,
        reset=callbacks.reset.address,
        compute=callbacks.compute.address,
        advance=callbacks.advance.address,
        visualize=visualize.address if visualize else None,
    )
    _registered.extend([callbacks, visualize, nstate, sensor, init, names, struct])
    if C.mjp_registerPlugin(ctypes.byref(struct)) < 0:
        raise EngineError(f"{PATH.name} refused the plugin {plugin.name}")


def register() -> tuple[str, ...]:
    """Make the plugins known to MuJoCo; a second call does nothing more.

    Returns:
        Their names.

    Raises:
        EngineError: the running MuJoCo does not have the layout that the plugins would read.
    """
    if not _registered:
        _verify_struct()
        layout, scene_layout = read_layout(), read_scene_layout()
        verify(layout)
        verify_scene(scene_layout)
        with announced():
            for definition in DEFINITIONS:
                _register(definition, layout, scene_layout)
        register_pickles(NAMES)
        guard_engines(NAMES)
        verify_state(layout, mujoco.MjData(mujoco.MjModel.from_xml_string(_SMALLEST)))
    return NAMES
