"""Registration of the plugins by the library itself, when any program loads it.

`mj_loadPluginLibrary` and `mj_loadAllPluginLibraries` load a library, whose constructor registers
what it has. The offsets of the MuJoCo that is running are looked up in `releases`; with a release
that is not there nothing is registered. A program in Python writes the offsets that it has
verified, and which of its functions check a model, and has the plugins registered then.

A binary model names a plugin by its slot alone, and what MuJoCo finds in a slot it calls unchecked.
The plugins have the same slots in every program, behind placeholders for plugins that are not
there: these refuse the instances of a model that has others.
"""

from __future__ import annotations

import sys
from collections.abc import Callable

import mujoco
import numpy as np

from tendon_mj.native import (
    ARRAYS,
    CONSTRUCTOR,
    ENGINE,
    ENGINE_ARRAY,
    ENTRIES,
    Addresses,
    External,
    LocalDoubles,
    Shared,
    Text,
    apart,
    entry,
)
from tendon_mj.plugin.abi import releases
from tendon_mj.plugin.abi.layout import LAYOUT, SCENE, Data, Model
from tendon_mj.plugin.abi.library import (
    mj_version,
    mjp_getPlugin,
    mjp_pluginCount,
    mjp_registerPlugin,
    mju_warning,
)
from tendon_mj.plugin.abi.memory import word, words
from tendon_mj.plugin.compiled_checks import refuse_slot, refuse_slot_of_data
from tendon_mj.plugin.force_servo_plugin import callbacks as _servo_callbacks  # noqa: F401, entries
from tendon_mj.plugin.force_servo_plugin.state import ATTRIBUTES as SERVO_ATTRIBUTES
from tendon_mj.plugin.sheath_plugin import callbacks as _sheath_callbacks  # noqa: F401
from tendon_mj.plugin.sheath_plugin import visualize as _visualize  # noqa: F401
from tendon_mj.plugin.sheath_plugin.attributes import ATTRIBUTES, as_rows
from tendon_mj.typing import IntArray

_KNOWN = releases.known()
_RELEASES = np.array([1000 * int(a) + int(b) for a, b in (name.split(".") for name in _KNOWN)])
_OFFSETS = np.array(list(_KNOWN.values()))
_COUNT = len(LAYOUT.names)
_layout, _scene = Shared(LAYOUT.symbol, _COUNT), Shared(SCENE.symbol, len(SCENE.names))

# of `mjpPlugin`, each a word, but for two ints that share one
MEMBERS = (
    "name nattribute attributes capabilityflags needstage nstate nsensordata init destroy copy"
    " reset compute advance visualize actuator_act_dot sdf_distance sdf_gradient sdf_staticdistance"
    " sdf_attribute sdf_aabb"
)
_ORDER = tuple(MEMBERS.split())
_SHARED = _ORDER.index("needstage")
_WORD = {name: k - (k >= _SHARED) for k, name in enumerate(_ORDER)}
_NAME, _ATTRIBUTE_COUNT, _ATTRIBUTES, _CAPABILITIES = range(_SHARED)
NSTATE = _WORD["nstate"]

_ACTUATOR, _SENSOR, _PASSIVE = 1, 2, 4  # mjtPluginCapabilityBit
_STAGE = mujoco.mjtStage.mjSTAGE_ACC.value
_WIDTH = 32  # of a row of text
_SHEATH_NAMES, _SERVO_NAMES = as_rows(ATTRIBUTES, _WIDTH), as_rows(SERVO_ATTRIBUTES, _WIDTH)
_SLOT = 16  # of the sheath, after MuJoCo's own plugins, which are half as many, and a user's
_PLACEHOLDERS = as_rows((f"tendon_mj.reserved.{k}" for k in range(_SLOT)), _WIDTH)
_sheath, _servo = Text("tendon_mj.sheath"), Text("tendon_mj.servo")
_WORDS = len(_ORDER) - 1
_struct = Shared("tendon_mj_struct", _WORDS)  # mjpPlugin, which MuJoCo copies
_names = Shared("tendon_mj_names", max(len(_SHEATH_NAMES), len(_SERVO_NAMES)))
_slot = Shared("tendon_mj_slot", 1)
_unknown = Text(
    "tendon_mj: the library does not know this release of MuJoCo; nothing is registered"
)

_IS_LINUX = sys.platform.startswith("linux")
_ANYWHERE = 0 if _IS_LINUX else -2  # RTLD_DEFAULT
_LOADED_ALREADY = 5  # RTLD_LAZY | RTLD_NOLOAD of Linux
_ENGINE_NAMES = as_rows(ENGINE, _WIDTH)
_functions = Shared(ENGINE_ARRAY, ARRAYS[ENGINE_ARRAY])
_found = LocalDoubles(1)
_library = Text("libmujoco")
_find_engine = Addresses("tendon_mj_find_engine")
_dlsym = External("dlsym", "ptr(ptr, ptr)")
_dlopen = External("dlopen", "ptr(ptr, i32)")
_dl_iterate_phdr = External("dl_iterate_phdr", "i32(ptr, ptr)")
_strstr = External("strstr", "ptr(ptr, ptr)")


def _functions_of(plugin: str) -> tuple[IntArray, Callable[[int], int]]:
    """Words of `mjpPlugin` that a plugin's entries fill, and the addresses of these."""
    entries = {f"tendon_mj_{plugin}_{name}": word for name, word in _WORD.items()}
    filled = {symbol: word for symbol, word in entries.items() if symbol in ENTRIES}
    return np.array(list(filled.values())), Addresses(*filled)


@apart
def _set_offsets() -> bool:
    """Write the offsets of the MuJoCo that is running; return whether they are known."""
    release = mj_version() // 1000
    for k in range(len(_RELEASES)):
        if _RELEASES[k] == release:
            for entry in range(_COUNT):
                words(_layout())[entry] = _OFFSETS[k, entry]
            for entry in range(_COUNT, _OFFSETS.shape[1]):
                words(_scene())[entry - _COUNT] = _OFFSETS[k, entry]
            return True
    return False


@apart
def _find_functions() -> bool:
    """Find MuJoCo's functions in the process; return whether all are there."""
    engine, found = _ANYWHERE, _found()
    if _dlsym(engine, _ENGINE_NAMES.ctypes.data) == 0 and _IS_LINUX:
        words(found)[0] = 0
        _dl_iterate_phdr(_find_engine(0), found)
        engine = word(found)
        if engine == 0:
            return False
    for k in range(len(_ENGINE_NAMES)):
        function = _dlsym(engine, _ENGINE_NAMES.ctypes.data + _WIDTH * k)
        if function == 0:
            return False
        words(_functions())[k] = function
    return True


@entry("tendon_mj_find_engine", "i32(ptr, i64, ptr)")
def find_engine(info: int, size: int, found: int) -> int:
    """Open MuJoCo's library once more where it is what `dl_iterate_phdr` shows; 1 ends that."""
    name = word(info + 8)
    if _strstr(name, _library()) == 0:
        return 0
    words(found)[0] = _dlopen(name, _LOADED_ALREADY)
    return 1


@apart
def _is_registered(name: int) -> bool:
    return mjp_getPlugin(name, _slot()) != 0


@apart
def _begin(name: int, attributes: int, count: int, capabilities: int) -> IntArray:
    """Make a new `mjpPlugin` without functions."""
    struct, names = words(_struct()), _names()
    for k in range(_WORDS):
        struct[k] = 0
    for k in range(count):
        words(names)[k] = attributes + _WIDTH * k
    struct[_NAME] = name
    struct[_ATTRIBUTE_COUNT], struct[_ATTRIBUTES] = count, names
    struct[_CAPABILITIES] = capabilities | _STAGE << 32  # two ints
    return struct


@entry("tendon_mj_placeholder_nsensordata", "i32(mjModel, i32, i32)")
def placeholder_nsensordata(m: Model, instance: int, sensor: int) -> int:
    """`nsensordata` of a placeholder, which `mj_loadModel` asks."""
    refuse_slot(m, instance)
    return 0


@entry("tendon_mj_placeholder_init", "i32(mjModel, mjData, i32)")
def placeholder_init(m: Model, d: Data, instance: int) -> int:
    """`init` of a placeholder, which `mj_makeData` asks."""
    refuse_slot_of_data(m, d, instance)
    return 0


_SHEATH_WORDS, _of_sheath = _functions_of("sheath")
_SERVO_WORDS, _of_servo = _functions_of("servo")
_PLACEHOLDER_WORDS, _of_placeholder = _functions_of("placeholder")


@apart
def _reserve() -> None:
    """Register placeholders in the slots before that of the sheath."""
    while mjp_pluginCount() < _SLOT:
        name = _PLACEHOLDERS.ctypes.data + _WIDTH * mjp_pluginCount()
        struct = _begin(name, 0, 0, _ACTUATOR | _SENSOR | _PASSIVE)
        for k in range(len(_PLACEHOLDER_WORDS)):
            struct[_PLACEHOLDER_WORDS[k]] = _of_placeholder(k)
        mjp_registerPlugin(_struct())


@entry("tendon_mj_register", "void()")
def register() -> None:
    """Register the plugins that are not registered yet."""
    if not _is_registered(_sheath()):
        _reserve()
        names, count = _SHEATH_NAMES.ctypes.data, len(_SHEATH_NAMES)
        struct = _begin(_sheath(), names, count, _ACTUATOR | _SENSOR | _PASSIVE)
        for k in range(len(_SHEATH_WORDS)):
            struct[_SHEATH_WORDS[k]] = _of_sheath(k)
        mjp_registerPlugin(_struct())
    if not _is_registered(_servo()):
        struct = _begin(_servo(), _SERVO_NAMES.ctypes.data, len(_SERVO_NAMES), _ACTUATOR)
        for k in range(len(_SERVO_WORDS)):
            struct[_SERVO_WORDS[k]] = _of_servo(k)
        mjp_registerPlugin(_struct())


@entry(CONSTRUCTOR, "void()")
def load() -> None:
    """Register the plugins when the library is loaded."""
    if not _find_functions():
        return
    if _set_offsets():
        register()
    else:
        mju_warning(_unknown())
