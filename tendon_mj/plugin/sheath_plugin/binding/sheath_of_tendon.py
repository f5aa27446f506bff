"""The sheath on a tendon of a model that MuJoCo compiles, found without a search for each asker."""

from __future__ import annotations

import threading
from collections.abc import Mapping

from tendon_mj.plugin.abi.model_in_compilation import Draft
from tendon_mj.plugin.sheath_plugin.binding.own_config import own_config

_ATTRIBUTES = ("tendon", "sensor")


class _Found(threading.local):
    """Sheath of each tendon as last seen in a thread; of any model, so only a guess."""

    def __init__(self) -> None:
        self.sheaths: dict[str, list[int]] = {}


_found = _Found()


def by_tendon(configs: Mapping[int, Mapping[str, str]]) -> dict[str, list[int]]:
    """Tendon to the instances that are sheaths on it, of the configurations of all instances."""
    found: dict[str, list[int]] = {}
    for instance, config in configs.items():
        if not config["sensor"]:
            found.setdefault(config["tendon"], []).append(instance)
    return found


def sheath_on(model: Draft, tendon: str, plugin: str) -> int | None:
    """Instance of the sheath on a tendon, None without one; ``plugin`` is the sheaths' name.

    A tendon has one sheath, so an instance that says it is on this tendon is the answer, wherever
    the guess came from. All instances are read only where the guess is wrong.
    """
    reader = Draft(model.address, _ATTRIBUTES)
    count = int(reader.fields.nplugin)
    for instance in _found.sheaths.get(tendon, ()):
        if instance < count and _is_sheath_on(reader, instance, tendon, plugin):
            return instance
    _found.sheaths = by_tendon(
        {k: own_config(reader, k) for k in range(count) if reader.plugin(k) == plugin}
    )
    return next(iter(_found.sheaths.get(tendon, ())), None)


def sheathed_tendons(model: Draft, plugin: str) -> list[str]:
    """Tendons that have a sheath."""
    reader = Draft(model.address, _ATTRIBUTES)
    instances = (k for k in range(int(reader.fields.nplugin)) if reader.plugin(k) == plugin)
    return list(by_tendon({k: own_config(reader, k) for k in instances}))


def _is_sheath_on(reader: Draft, instance: int, tendon: str, plugin: str) -> bool:
    if reader.plugin(instance) != plugin:
        return False
    config = own_config(reader, instance)
    return config["tendon"] == tendon and not config["sensor"]
