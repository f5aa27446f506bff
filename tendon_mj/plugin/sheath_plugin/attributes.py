"""Attributes of a plugin instance: their names, their meaning, and how compiled code reads them.

MuJoCo keeps an instance's attribute values as one block of zero-terminated strings, in the order in
which the plugin was registered with them.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tendon_mj.native import LocalDoubles, compiled
from tendon_mj.plugin.abi.layout import Model
from tendon_mj.plugin.abi.library import read_number
from tendon_mj.plugin.abi.memory import address_of, letters
from tendon_mj.plugin.sheath_plugin.state import PARAMETERS

NAME: Final = "tendon_mj.sheath"  # of the plugin
# kind -> (quantity, unit, whether one number per "segment" or "guide" or one in all)
KINDS: dict[str, tuple[str, str, str]] = {
    "input_tension": ("tension at the input end", "N", "one"),
    "output_tension": ("tension at the output end", "N", "one"),
    "tension": ("tension of each segment, input side first", "N", "segment"),
    "bend_angle": ("bend at each guide", "rad", "guide"),
    "slip": ("+1 sliding towards the input, -1 towards the output, 0 at rest", "-", "guide"),
    "friction_work": ("friction work at each guide since the reset", "J", "guide"),
    "reel_displacement": ("tendon wound in at the input", "m", "one"),
    "unsolved": ("evaluations whose flow was not solved since the reset", "-", "one"),
}
(
    INPUT_TENSION,
    OUTPUT_TENSION,
    TENSION,
    BEND_ANGLE,
    SLIP,
    FRICTION_WORK,
    REEL_DISPLACEMENT,
    UNSOLVED,
) = range(len(KINDS))


ENDS = 2  # numbers of a sensor on the sheath's own instance: T_in and T_out


def is_one_number(kind: str) -> bool:
    """Return whether a sensor of this kind has one number, whatever its sheath."""
    return KINDS[kind][2] == "one"


@compiled
def numbers_of(kind: int, guides: int) -> int:
    """How many numbers a sensor of a kind has on a sheath with so many guides."""
    if kind == TENSION:
        return guides + 1
    return guides if kind in (BEND_ANGLE, SLIP, FRICTION_WORK) else 1


class Attachment(NamedTuple):
    """Description of an attribute that is not a parameter."""

    text: str
    kind: str  # of value
    default: str


# Attributes that attach a sheath to its model; with PARAMETERS all attributes, in their order. The
# first, which tells sheaths from sensors, is read in every step.
ATTACHMENT: Final = {
    "sensor": Attachment("quantity that a sensor's instance shows, see below", "word", "none"),
    "tendon": Attachment("tendon in the sheath, as it is called here", "name", "required"),
    "reel_joint": Attachment("hinge or slide that winds tendon in at the input", "name", "none"),
    "output_joint": Attachment("the same at the output, such as a joint's pulley", "name", "none"),
    "guides": Attachment("number of guides; give it with several tendons", "1", "counted"),
    "arc_guides": Attachment("guides on each geom that the tendon wraps around", "1", "1"),
    "inner_guides": Attachment("guides at its input end, for `extra_bend`", "1", "0"),
    "input_end": Attachment("its site at which it is pulled: `first` or `last`", "word", "first"),
    "instance": Attachment("no meaning now; earlier releases wrote it", "name", "none"),
    "spring": Attachment(
        "the tendon's own spring: the `cable`'s elasticity, or one at its `input` that pulls it",
        "word",
        "input",
    ),
}
ATTRIBUTES: Final = (*ATTACHMENT, *PARAMETERS)
(
    SENSOR,
    TENDON,
    REEL_JOINT,
    OUTPUT_JOINT,
    GUIDES,
    ARC_GUIDES,
    INNER_GUIDES,
    INPUT_END,
    INSTANCE,
    SPRING,
) = range(len(ATTACHMENT))
FIRST_PARAMETER: Final = len(ATTACHMENT)
AXIAL_STIFFNESS: Final = FIRST_PARAMETER + list(PARAMETERS).index("axial_stiffness")
PRETENSION: Final = FIRST_PARAMETER + list(PARAMETERS).index("pretension")
SLACK: Final = FIRST_PARAMETER + list(PARAMETERS).index("slack")
STIFFENING: Final = FIRST_PARAMETER + list(PARAMETERS).index("stiffening")
CREEP: Final = FIRST_PARAMETER + list(PARAMETERS).index("creep")
AXIAL_DAMPING: Final = FIRST_PARAMETER + list(PARAMETERS).index("axial_damping")
INPUT_ENDS: Final = ("first", "last")  # sites of the path as it is drawn
SPRINGS: Final = ("input", "cable")


def as_rows(known: Iterable[str], width: int = 32) -> NDArray[np.uint8]:
    """Words as zero-terminated rows, for ``index_of``."""
    rows = [word.encode().ljust(width, b"\0") for word in known]
    return np.frombuffer(b"".join(rows), np.uint8).reshape(-1, width)


_end = LocalDoubles(1)
KIND_NAMES = as_rows(KINDS)
END_NAMES = as_rows(INPUT_ENDS)
SPRING_NAMES = as_rows(SPRINGS)


@compiled
def text_at(m: Model, instance: int, attribute: int) -> int:
    """Address of an attribute's value, a zero-terminated string."""
    address = address_of(m.plugin_attr) + m.plugin_attradr[instance]
    for _ in range(attribute):
        while letters(address)[0] != 0:
            address += 1
        address += 1
    return address


@compiled
def is_given(m: Model, instance: int, attribute: int) -> bool:
    """Return whether an attribute is written."""
    return letters(text_at(m, instance, attribute))[0] != 0


@compiled
def is_sensor(m: Model, instance: int) -> bool:
    """Return whether an instance has sensors of sheaths, and is not a sheath itself."""
    return is_given(m, instance, SENSOR)


@compiled
def is_sheath(m: Model, other: int, instance: int) -> bool:
    """Return whether an instance is a sheath, of the plugin of ``instance``."""
    return m.plugin[other] == m.plugin[instance] and not is_sensor(m, other)


@compiled
def first_sheath(m: Model, instance: int) -> int:
    """First sheath of a model, of the plugin of ``instance``; −1 for none."""
    for other in range(m.nplugin):
        if is_sheath(m, other, instance):
            return other
    return -1


@compiled
def last_sheath(m: Model, instance: int) -> int:
    """Last sheath of a model, of the plugin of ``instance``; −1 for none."""
    for other in range(m.nplugin - 1, -1, -1):
        if is_sheath(m, other, instance):
            return other
    return -1


@compiled
def number_at(address: int) -> float:
    """Number that a string holds, 0 for an empty one."""
    return 0.0 if letters(address)[0] == 0 else read_number(address, _end())


@compiled
def index_of(address: int, known: NDArray[np.uint8]) -> int:
    """Index of a string among the known words, −1 for none."""
    for word in range(known.shape[0]):
        k = 0
        while k < 31 and letters(address)[k] == known[word, k]:
            if known[word, k] == 0:
                return word
            k += 1
    return -1


@compiled
def sensor_kind(m: Model, instance: int) -> int:
    """Index of an instance's kind of sensor, −1 for none."""
    return index_of(text_at(m, instance, SENSOR), KIND_NAMES)


@compiled
def is_input_at_last(m: Model, instance: int) -> bool:
    """Return whether the input end is the last site of the path."""
    return index_of(text_at(m, instance, INPUT_END), END_NAMES) == 1


@compiled
def is_cable_spring(m: Model, instance: int) -> bool:
    """Return whether the tendon's own spring is the cable's elasticity."""
    return index_of(text_at(m, instance, SPRING), SPRING_NAMES) == 1


@compiled
def has_length(m: Model, instance: int) -> bool:
    """Return whether a sheath's pretension or slack is written, so that its tendon has a length."""
    return is_given(m, instance, PRETENSION) or is_given(m, instance, SLACK)


@compiled
def number(m: Model, instance: int, attribute: int) -> float:
    """An attribute's number, 0 if it is not written."""
    return number_at(text_at(m, instance, attribute))
