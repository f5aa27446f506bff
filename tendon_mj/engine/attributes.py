"""The configuration of a plugin instance as text: which attributes there are and how to read them.

MuJoCo keeps an instance's attribute values as one block of zero-terminated strings, in the order in
which the plugin was registered with them.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from tendon_mj.engine.library import strtod
from tendon_mj.engine.measure import KINDS
from tendon_mj.engine.memory import byte, integer, pointer
from tendon_mj.engine.state import PARAMETERS
from tendon_mj.sheath.compiled import compiled

ATTRIBUTES = (*PARAMETERS, "tendon", "reel_joint", "output_joint", "sensor", "guides")
TENDON, REEL_JOINT, OUTPUT_JOINT, SENSOR, _GUIDES = range(len(PARAMETERS), len(ATTRIBUTES))

_KIND_NAMES = np.zeros((len(KINDS), 32), np.uint8)
for _row, _kind in zip(_KIND_NAMES, KINDS, strict=True):
    _row[: len(_kind)] = np.frombuffer(_kind.encode(), np.uint8)


@compiled
def text(layout: Any, m: int, instance: int, attribute: int) -> int:
    """Address of an attribute's value, a zero-terminated string."""
    start = integer(pointer(m + layout.m_plugin_attradr), instance)
    address = pointer(m + layout.m_plugin_attr) + start
    for _ in range(attribute):
        while byte(address, 0) != 0:
            address += 1
        address += 1
    return address


@compiled
def number(address: int) -> float:
    """The number that a string holds, 0 for an empty one."""
    return 0.0 if byte(address, 0) == 0 else strtod(address, 0)


@compiled
def same(one: int, other: int) -> bool:
    """Whether two strings are equal."""
    k = 0
    while byte(one, k) == byte(other, k):
        if byte(one, k) == 0:
            return True
        k += 1
    return False


@compiled
def sensor_kind(address: int) -> int:
    """Which kind of sensor a string names, −1 for none."""
    for kind in range(_KIND_NAMES.shape[0]):
        k = 0
        while k < 31 and byte(address, k) == _KIND_NAMES[kind, k]:
            if _KIND_NAMES[kind, k] == 0:
                return kind
            k += 1
    return -1
