"""Names that sheaths, their sensors and their plugin instances are given where none is said.

A call for one tendon by its name takes short names where they are free: ``sheath``, and the kind of
each sensor. A call for several, or for a list of one, takes ``<tendon>_sheath`` and
``<tendon>_<kind>``, which do not depend on what else is in the model or in which order it was
added. So does a call for one where the short names are taken. Nothing is ever renamed.
"""

from __future__ import annotations

from collections.abc import Container, Sequence
from itertools import count
from typing import NamedTuple

import mujoco


class SheathNames(NamedTuple):
    """Names of a sheath and of what shows it.

    Attributes:
        sheath: the plugin instance.
        ends: the sensor that shows T_in and T_out.
        sensors: kind → (sensor, its plugin instance).
    """

    sheath: str
    ends: str
    sensors: dict[str, tuple[str, str]]


class TakenNames:
    """Names of a model's plugin instances and sensors, to which names that are given out are added.

    Args:
        spec: read once, not changed.
    """

    def __init__(self, spec: mujoco.MjSpec) -> None:
        self.instances = {plugin.name for plugin in spec.plugins}
        self.sensors = {sensor.name for sensor in spec.sensors}

    def of_one(self, tendon: str, kinds: Sequence[str], sheath: str | None) -> SheathNames:
        """Names for the sheath of a tendon that was asked for alone; ``sheath`` where it is given.

        The names of the sensors are distinct from each other and from all there are.
        """
        name = free_name(self.instances, "sheath", f"{tendon}_sheath") if sheath is None else sheath
        prefix = tendon if sheath is None else sheath
        return self._give(name, {kind: (kind, f"{prefix}_{kind}") for kind in kinds})

    def of_several(self, tendon: str, kinds: Sequence[str]) -> SheathNames:
        """Names for the sheath of a tendon that was asked for among others."""
        name = free_name(self.instances, f"{tendon}_sheath")
        return self._give(name, {kind: (f"{tendon}_{kind}",) for kind in kinds})

    def _give(self, sheath: str, candidates: dict[str, tuple[str, ...]]) -> SheathNames:
        self.instances.add(sheath)
        ends = free_name(self.sensors, sheath, f"{sheath}_ends")
        self.sensors.add(ends)
        sensors = {}
        for kind, names in candidates.items():
            sensors[kind] = (
                free_name(self.sensors, *names),
                free_name(self.instances, f"{sheath}.{kind}"),
            )
            self.sensors.add(sensors[kind][0])
            self.instances.add(sensors[kind][1])
        return SheathNames(sheath, ends, sensors)


def free_name(taken: Container[str], *candidates: str) -> str:
    """The first candidate that is not taken; where all are, the last one with a number behind."""
    for name in candidates:
        if name not in taken:
            return name
    return next(name for k in count(2) if (name := f"{candidates[-1]}_{k}") not in taken)
