"""Attributes of a plugin instance: their names, their meaning, and how compiled code reads them.

MuJoCo keeps an instance's attribute values as one block of zero-terminated strings, in the order in
which the plugin was registered with them.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tendon_mj.compilation import compiled
from tendon_mj.plugin.abi.layout import Layout
from tendon_mj.plugin.abi.library import strtod
from tendon_mj.plugin.abi.memory import byte, integer, pointer
from tendon_mj.plugin.sheath_plugin.sensors import KINDS
from tendon_mj.plugin.sheath_plugin.state import PARAMETERS


class Attachment(NamedTuple):
    """Description of an attribute that is no number of the law."""

    text: str
    kind: str  # of value
    default: str


# How a sheath is attached to its model; with PARAMETERS, all attributes in their order. The first,
# which tells sheaths from sensors, is read in every step.
ATTACHMENT: Final = {
    "sensor": Attachment("quantity that a sensor's instance shows, see below", "word", "none"),
    "tendon": Attachment("spatial tendon that runs in the sheath", "name", "required"),
    "reel_joint": Attachment("hinge or slide that winds tendon in at the input", "name", "none"),
    "output_joint": Attachment("the same at the output, such as a joint's pulley", "name", "none"),
    "guides": Attachment("number of guides; give it with several tendons", "1", "counted"),
    "arc_guides": Attachment("guides on each geom that the tendon wraps around", "1", "1"),
    "inner_guides": Attachment("guides at its input end, for `extra_bend`", "1", "0"),
    "input_end": Attachment("its site at which it is pulled: `first` or `last`", "word", "first"),
    "instance": Attachment("name of the instance where this is written", "name", "none"),
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
    _GUIDES,
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
INPUT_ENDS: Final = ("first", "last")  # sites of the path as it is drawn
SPRINGS: Final = ("input", "cable")


def as_rows(known: Iterable[str]) -> NDArray[np.uint8]:
    """Words as zero-terminated rows, for ``index_of``."""
    rows = [word.encode().ljust(32, b"\0") for word in known]
    return np.frombuffer(b"".join(rows), np.uint8).reshape(-1, 32)


_KIND_NAMES = as_rows(KINDS)
_END_NAMES = as_rows(INPUT_ENDS)
_SPRING_NAMES = as_rows(SPRINGS)


@compiled
def text_at(layout: Layout, m: int, instance: int, attribute: int) -> int:
    """Address of an attribute's value, a zero-terminated string."""
    start = integer(pointer(m + layout.m_plugin_attradr), instance)
    address = pointer(m + layout.m_plugin_attr) + start
    for _ in range(attribute):
        while byte(address, 0) != 0:
            address += 1
        address += 1
    return address


@compiled
def has_length(layout: Layout, m: int, instance: int) -> bool:
    """Whether a sheath's pretension or slack is stated, so that its tendon has a length."""
    return (
        byte(text_at(layout, m, instance, PRETENSION), 0) != 0
        or byte(text_at(layout, m, instance, SLACK), 0) != 0
    )


@compiled
def is_sensor(layout: Layout, m: int, instance: int) -> bool:
    """Whether an instance shows something of sheaths, and is none itself."""
    return byte(text_at(layout, m, instance, SENSOR), 0) != 0


@compiled
def number_at(address: int) -> float:
    """Number that a string holds, 0 for an empty one."""
    return 0.0 if byte(address, 0) == 0 else strtod(address, 0)


@compiled
def index_of(address: int, known: NDArray[np.uint8]) -> int:
    """Index of a string among the known words, −1 for none."""
    for word in range(known.shape[0]):
        k = 0
        while k < 31 and byte(address, k) == known[word, k]:
            if known[word, k] == 0:
                return word
            k += 1
    return -1


@compiled
def sensor_kind_at(address: int) -> int:
    """Index of the kind of sensor that a string names, −1 for none."""
    return index_of(address, _KIND_NAMES)


@compiled
def input_end_at(address: int) -> int:
    """Index of the input end that a string names, that of the first site where it is empty."""
    return max(0, index_of(address, _END_NAMES))


@compiled
def is_cable_spring(address: int) -> bool:
    """Whether a string says that the tendon's own spring is the cable's elasticity."""
    return index_of(address, _SPRING_NAMES) == 1
