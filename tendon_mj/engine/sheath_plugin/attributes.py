"""The configuration of a plugin instance as text: which attributes there are and how to read them.

MuJoCo keeps an instance's attribute values as one block of zero-terminated strings, in the order in
which the plugin was registered with them.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tendon_mj.compilation import compiled
from tendon_mj.engine.abi.library import strtod
from tendon_mj.engine.abi.memory import byte, integer, pointer
from tendon_mj.engine.sheath_plugin.measure import KINDS
from tendon_mj.engine.sheath_plugin.state import PARAMETERS

ATTRIBUTES = (*PARAMETERS, "tendon", "reel_joint", "output_joint", "sensor", "guides")
TENDON, REEL_JOINT, OUTPUT_JOINT, SENSOR, _GUIDES = range(len(PARAMETERS), len(ATTRIBUTES))


def words(known: Iterable[str]) -> NDArray[np.uint8]:
    """Words for ``which``, as compiled code can hold them."""
    rows = [word.encode().ljust(32, b"\0") for word in known]
    return np.frombuffer(b"".join(rows), np.uint8).reshape(-1, 32)


_KIND_NAMES = words(KINDS)


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
def which(address: int, known: Any) -> int:
    """Which of the known words a string is, −1 for none."""
    for word in range(known.shape[0]):
        k = 0
        while k < 31 and byte(address, k) == known[word, k]:
            if known[word, k] == 0:
                return word
            k += 1
    return -1


@compiled
def sensor_kind(address: int) -> int:
    """Which kind of sensor a string names, −1 for none."""
    return which(address, _KIND_NAMES)
