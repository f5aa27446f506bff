"""Names in an instance's configuration, and the elements that they mean after `attach`.

MuJoCo's `attach` puts a prefix and a suffix around the names of all that it attaches, plugin
instances among them, and leaves the configurations as they are. An instance's own name shows both:
the attribute `instance` keeps the name where its configuration was written, so that an instance
``left_sheath`` with `instance` = ``sheath`` has the prefix ``left_``, also on its tendon. Without
the attribute a name is meant to the letter; where there is no such tendon, it is the one that
shares a prefix and a suffix with the instance. An instance without a name goes by the sensor or
actuator that has it.

`prefix_and_suffix`, for the checks in Python, and `resolve`, for compiled code, have one rule.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from typing import NamedTuple

import mujoco
import numpy as np

from tendon_mj.errors import InvalidValueError, UnknownNameError
from tendon_mj.native import apart
from tendon_mj.plugin.abi.draft import Draft
from tendon_mj.plugin.abi.layout import Model
from tendon_mj.plugin.abi.library import C, free, malloc, mj_id2name, mj_name2id
from tendon_mj.plugin.abi.memory import letters
from tendon_mj.plugin.sheath_plugin import attributes as at

_OBJ = mujoco.mjtObj
_PLUGIN, _TENDON = _OBJ.mjOBJ_PLUGIN.value, _OBJ.mjOBJ_TENDON.value
_SENSOR, _ACTUATOR = _OBJ.mjOBJ_SENSOR.value, _OBJ.mjOBJ_ACTUATOR.value


class Affixes(NamedTuple):
    """Prefix and suffix that `attach` gave to an instance and to all that it names."""

    prefix: str
    suffix: str

    def around(self, name: str) -> str:
        """A name as the element is called now; no name stays none."""
        return f"{self.prefix}{name}{self.suffix}" if name else ""


NONE = Affixes("", "")


def around_written(own: str, written: str) -> list[Affixes]:
    """Prefix and suffix around each occurrence of the written name in a name as it is now."""
    starts = (k for k in range(len(own)) if written and own.startswith(written, k))
    return [Affixes(own[:k], own[k + len(written) :]) for k in starts]


def around_tendon(own: str, tendon: str, tendons: Iterable[str]) -> list[Affixes]:
    """Prefixes and suffixes that an instance shares with a tendon whose name has `tendon` in it.

    Something of the instance's own name is left between them; the shortest prefix comes first, and
    of those with one prefix the longest suffix.
    """
    shared = {
        affixes
        for name in tendons
        for affixes in around_written(name, tendon)
        if own.startswith(affixes.prefix) and own.endswith(affixes.suffix)
    }
    possible = [a for a in shared if len(a.prefix) + len(a.suffix) < len(own)]
    return sorted(possible, key=lambda a: (len(a.prefix), -len(a.suffix)))


def prefix_and_suffix(
    own: str, written: str, tendon: str, tendons: Collection[str]
) -> list[Affixes]:
    """Prefix and suffix that `attach` gave to an instance: one answer, or several equally good.

    Args:
        own: name of the instance now.
        written: its attribute `instance`.
        tendon: its attribute `tendon`.
        tendons: names of the model's tendons.
    """
    around = around_written(own, written)
    if around:
        return [a for a in around if a.around(tendon) in tendons] or around[:1]
    if not tendon or tendon in tendons:
        return [NONE]
    return around_tendon(own, tendon, tendons) or [NONE]


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
def _length(text: int) -> int:
    """Bytes of a zero-terminated string; 0 at address 0."""
    count = 0
    while text != 0 and letters(text)[count] != 0:
        count += 1
    return count


@apart
def _index(m: Model, kind: int, own: int, end: int, start: int, text: int) -> int:
    """Index of the element called own[:end] + text + own[start:], −1 for none."""
    count, last = _length(text), _length(own) - start
    name = malloc(end + count + last + 1)
    if count == 0 or name == 0:
        free(name)
        return -1
    for k in range(end):
        letters(name)[k] = letters(own)[k]
    for k in range(count):
        letters(name)[end + k] = letters(text)[k]
    for k in range(last + 1):
        letters(name)[end + count + k] = letters(own)[start + k] if k < last else 0
    index = mj_name2id(m, kind, name)
    free(name)
    return index


@apart
def _affixes(m: Model, own: int, written: int, tendon: int) -> tuple[int, int]:
    """Where the prefix of a name ends and its suffix starts, as `prefix_and_suffix` has it."""
    last, inner = _length(own), _length(written)
    exists, first, prefix_end, suffix_start = False, True, 0, last
    if inner > 0:
        for end in range(last - inner + 1):
            if not _same(own, end, written, 0, inner):
                continue
            fits = _index(m, _TENDON, own, end, end + inner, tendon) >= 0
            if first or (fits and not exists):
                prefix_end, suffix_start = end, end + inner
                first = False
            exists |= fits
    if not first or _index(m, _TENDON, own, 0, last, tendon) >= 0:
        return prefix_end, suffix_start
    return _shared(m, own, tendon)


@apart
def _shared(m: Model, own: int, tendon: int) -> tuple[int, int]:
    """As `_affixes`, by the first that `around_tendon` gives."""
    last, inner = _length(own), _length(tendon)
    prefix_end, suffix_start = last, last
    for index in range(m.ntendon if inner > 0 else 0):
        name = mj_id2name(m, _TENDON, index)
        count = _length(name)
        for end in range(min(last, count - inner + 1)):
            start = last - (count - end - inner)  # where the suffix would begin
            better = end < start and (end, start) < (prefix_end, suffix_start)
            if (
                better
                and _same(name, end, tendon, 0, inner)
                and _same(name, end + inner, own, start, last - start)
            ):
                prefix_end, suffix_start = end, start
            if letters(own)[end] != letters(name)[end]:
                break
    return (0, last) if prefix_end == last else (prefix_end, suffix_start)


@apart
def _same(text: int, at: int, other: int, other_at: int, count: int) -> bool:
    """Whether ``count`` bytes of two strings are the same, each from its own place on."""
    k = 0
    while k < count and letters(text)[at + k] == letters(other)[other_at + k]:
        k += 1
    return k == count


@apart
def resolve_from(
    m: Model, instance: int, tendon: int, written: int, attribute: int, kind: int
) -> int:
    """As ``resolve``, of a plugin whose attributes `tendon` and `instance` are these."""
    own = own_name(m, instance)
    end, start = _affixes(
        m,
        own,
        at.text_at(m, instance, written),
        at.text_at(m, instance, tendon),
    )
    return _index(m, kind, own, end, start, at.text_at(m, instance, attribute))


@apart
def resolve(m: Model, instance: int, attribute: int, kind: int) -> int:
    """Index of the element, an `mjtObj`, that an attribute of a sheath names, −1 for none."""
    return resolve_from(m, instance, at.TENDON, at.INSTANCE, attribute, kind)


_WRAP = mujoco.mjtWrap
_NAMES = ("tendon", "reel_joint", "output_joint")  # attributes that name an element
_ON_PATH = {
    _WRAP.mjWRAP_SITE.value: _OBJ.mjOBJ_SITE,
    _WRAP.mjWRAP_SPHERE.value: _OBJ.mjOBJ_GEOM,
    _WRAP.mjWRAP_CYLINDER.value: _OBJ.mjOBJ_GEOM,
    _WRAP.mjWRAP_JOINT.value: _OBJ.mjOBJ_JOINT,
}


def own_config(model: Draft, instance: int) -> dict[str, str]:
    """Attributes of a plugin instance, each name with the prefix and suffix of the instance.

    Raises:
        InvalidValueError: several tendons may be meant.
    """
    config = model.config(instance)
    affixes = _affixes_of(model, instance, config)
    return {k: affixes.around(v) if k in _NAMES else v for k, v in config.items()}


def check_own_names(model: Draft, instances: Iterable[int]) -> None:
    """Refuse names that may be meant to the letter or not; the model is complete.

    Raises:
        InvalidValueError: there is a tendon of the name as written, and one with the prefix.
        UnknownNameError: the tendon only seems to share a prefix with the instance.
    """
    for instance in instances:
        own_config(model, instance)
        own, tendon = _own_name(model, instance), _read(model, instance, "tendon")
        if around_written(own, _read(model, instance, "instance")):
            continue
        chosen = _affixes_of(model, instance, {"tendon": tendon, "instance": ""})
        if chosen != NONE:
            if not _carries(model, model.tendons[chosen.around(tendon)], chosen):
                raise UnknownNameError("tendon", tendon, model.tendons, model.where(instance))
            continue
        for affixes in around_tendon(own, tendon, model.tendons):
            other = affixes.around(tendon)
            if other != tendon and _carries(model, model.tendons[other], affixes):
                raise _ambiguous(model, instance, [tendon, other])


def _affixes_of(model: Draft, instance: int, config: Mapping[str, str]) -> Affixes:
    """Prefix and suffix of an instance, by its configuration."""
    own = _own_name(model, instance)
    written, tendon = (
        config[name] if name in config else _read(model, instance, name)
        for name in ("instance", "tendon")
    )
    possible = prefix_and_suffix(own, written, tendon, model.tendons)
    if len({affixes.around(tendon) for affixes in possible}) > 1:
        raise _ambiguous(model, instance, [affixes.around(tendon) for affixes in possible])
    return possible[0]


def _read(model: Draft, instance: int, attribute: str) -> str:
    return (C.mj_getPluginConfig(model.address, instance, attribute.encode()) or b"").decode()


def _ambiguous(model: Draft, instance: int, tendons: Iterable[str]) -> InvalidValueError:
    meant = " or ".join(repr(name) for name in tendons)
    return InvalidValueError(
        f"{model.where(instance)}: its tendon may be {meant}, as `attach` renames an instance and "
        'not the names in it; write its name before `attach`, <config key="instance" '
        'value="…"/>, or its present one if the tendon is meant to the letter'
    )


def _own_name(model: Draft, instance: int) -> str:
    """Name of an instance, or of the first sensor or actuator that has it."""
    name = model.name(_OBJ.mjOBJ_PLUGIN, instance)
    if name:
        return name
    for kind, owners in (
        (_OBJ.mjOBJ_SENSOR, model.sensor_plugin),
        (_OBJ.mjOBJ_ACTUATOR, model.actuator_plugin),
    ):
        for first in np.flatnonzero(owners == instance)[:1]:
            return model.name(kind, first)
    return ""


def _carries(model: Draft, tendon: int, affixes: Affixes) -> bool:
    """Whether all that is named on a tendon's path has a prefix and a suffix."""
    start, names = model.tendon_adr[tendon], []
    for k in range(start, start + model.tendon_num[tendon]):
        kind = _ON_PATH.get(model.wrap_type[k])
        if kind is not None:
            names.append(model.name(kind, model.wrap_objid[k]))
    return all(n.startswith(affixes.prefix) and n.endswith(affixes.suffix) for n in names if n)


def sheathed_tendons(model: Draft) -> list[str]:
    """Names of the tendons with a sheath."""
    reader = Draft(model.address, ("tendon", "sensor"))
    instances = (k for k in range(reader.nplugin) if reader.plugin_name(k) == at.NAME)
    return [c["tendon"] for c in (own_config(reader, k) for k in instances) if not c["sensor"]]
