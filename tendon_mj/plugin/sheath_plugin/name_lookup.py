"""The tendon and the joints of a sheath, also after `attach` and `replicate`.

Its tendon is the object of its sensor, or what its reel acts on: MuJoCo keeps both as it renames or
copies what it attaches. It leaves configurations as they are written; the prefix and suffix around
the joints in them are those of the tendon. Without an object a tendon is meant to the letter: an
instance that no sensor or actuator refers to is not attached.
"""

from __future__ import annotations

from typing import Final

import mujoco

from tendon_mj.native import apart
from tendon_mj.plugin.abi.layout import Model
from tendon_mj.plugin.abi.library import free, malloc, mj_id2name, mj_name2id, plugin_name
from tendon_mj.plugin.abi.memory import letters
from tendon_mj.plugin.sheath_plugin import attributes as at
from tendon_mj.plugin.sheath_plugin.input_force import ON_TENDON

_OBJ = mujoco.mjtObj
_PLUGIN, TENDON, _JOINT = (
    kind.value for kind in (_OBJ.mjOBJ_PLUGIN, _OBJ.mjOBJ_TENDON, _OBJ.mjOBJ_JOINT)
)
_SENSOR, _ACTUATOR = _OBJ.mjOBJ_SENSOR.value, _OBJ.mjOBJ_ACTUATOR.value
_ON_JOINT = mujoco.mjtTrn.mjTRN_JOINT.value
_SHEATH = at.as_rows((at.NAME,))
SEVERAL: Final = -2  # joints that may be meant


@apart
def own_name(m: Model, instance: int) -> int:
    """Address of an instance's name, or of its sensor's or actuator's; 0 without any."""
    name = mj_id2name(m, _PLUGIN, instance)
    if name != 0 and letters(name)[0] != 0:
        return name
    for k in range(m.nsensor):
        if m.sensor_plugin[k] == instance:
            return mj_id2name(m, _SENSOR, k)
    for k in range(m.nactuator):
        if m.actuator_plugin[k] == instance:
            return mj_id2name(m, _ACTUATOR, k)
    return 0


@apart
def named_tendon(m: Model, instance: int) -> int:
    """Index of the tendon that an instance names to the letter, −1 for none."""
    return mj_name2id(m, TENDON, at.text_at(m, instance, at.TENDON))


@apart
def tendon_of(m: Model, instance: int) -> int:
    """Index of the tendon of a sheath, −1 for none."""
    for k in range(m.nsensor):
        if m.sensor_plugin[k] == instance and m.sensor_objtype[k] == TENDON:
            return m.sensor_objid[k]
    for k in range(m.nactuator):
        if m.actuator_plugin[k] == instance and m.actuator_trntype[k] == ON_TENDON:
            return m.actuator_trnid[k, 0]
    return named_tendon(m, instance)


@apart
def tendon_of_sensor(m: Model, sensor: int) -> int:
    """Index of the tendon that a sensor shows, −1 for none."""
    if m.sensor_objtype[sensor] == TENDON:
        return m.sensor_objid[sensor]
    return named_tendon(m, m.sensor_plugin[sensor])


@apart
def _length(text: int) -> int:
    """Bytes of a zero-terminated string; 0 at address 0."""
    count = 0
    while text != 0 and letters(text)[count] != 0:
        count += 1
    return count


@apart
def place_of(text: int, part: int, start: int) -> int:
    """If a string holds another, from a place on; −1 if it does not."""
    count = _length(part)
    for place in range(start, _length(text) - count + 1):
        k = 0
        while k < count and letters(text)[place + k] == letters(part)[k]:
            k += 1
        if k == count:
            return place
    return -1


@apart
def _joint_in(m: Model, tendon: int, place: int, written: int, joint: int) -> int:
    """Index of the joint with the letters around the written name in a tendon's; −1 for none."""
    before, after = _length(written), _length(joint)
    count = _length(tendon) - before + after
    name = malloc(count + 1)
    if name == 0:
        return -1
    for k in range(count):
        if k < place:
            letters(name)[k] = letters(tendon)[k]
        elif k < place + after:
            letters(name)[k] = letters(joint)[k - place]
        else:
            letters(name)[k] = letters(tendon)[k - after + before]
    letters(name)[count] = 0
    index = mj_name2id(m, _JOINT, name)
    free(name)
    return index


@apart
def joint_of(m: Model, instance: int, attribute: int) -> int:
    """Index of the joint that an attribute of a sheath names, −1 for none, `SEVERAL` of several."""
    index, tendon, joint = -1, tendon_of(m, instance), at.text_at(m, instance, attribute)
    if tendon < 0 or letters(joint)[0] == 0:
        return -1
    name, written = mj_id2name(m, TENDON, tendon), at.text_at(m, instance, at.TENDON)
    place = place_of(name, written, 0)
    while place >= 0:
        other = _joint_in(m, name, place, written, joint)
        if index >= 0 and other >= 0 and other != index:
            return SEVERAL
        index = max(index, other)
        place = place_of(name, written, place + 1)
    return index


@apart
def is_same(text: int, other: int) -> bool:
    """Return whether two strings are the same."""
    return place_of(text, other, 0) == 0 and place_of(other, text, 0) == 0


@apart
def motor_of(m: Model, actuator: int) -> int:
    """Index of the joint that an actuator drives, −1 for none."""
    return m.actuator_trnid[actuator, 0] if m.actuator_trntype[actuator] == _ON_JOINT else -1


@apart
def sheath_wound_by(m: Model, servo: int, attribute: int) -> int:
    """The sheath that the joint of a servo winds in, on the tendon of an attribute; −1 for none.

    Its tendon is called so now, or where both configurations are written. A sheath whose joint does
    not exist counts, as it is refused itself.
    """
    written = at.text_at(m, servo, attribute)
    for k in range(m.nactuator):
        joint = motor_of(m, k) if m.actuator_plugin[k] == servo else -1
        for other in range(m.nplugin if joint >= 0 else 0):
            if at.index_of(plugin_name(m, other), _SHEATH) != 0 or at.is_sensor(m, other):
                continue
            wound = joint_of(m, other, at.REEL_JOINT)
            if wound == joint or (wound < 0 and at.is_given(m, other, at.REEL_JOINT)):
                name = mj_id2name(m, TENDON, tendon_of(m, other))
                if is_same(at.text_at(m, other, at.TENDON), written) or is_same(name, written):
                    return other
    return -1
