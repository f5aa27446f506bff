"""Sheaths with more guides than a model has, for simulations that lump them less."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import mujoco
import numpy as np

from tendon_mj.attach import sheaths_by_tendon
from tendon_mj.lab.units import ROUNDING
from tendon_mj.typing import FloatArray

_WRAP = mujoco.mjtWrap
_JOINT, _SITE, _PULLEY = _WRAP.mjWRAP_JOINT, _WRAP.mjWRAP_SITE, _WRAP.mjWRAP_PULLEY
_SLIDE = mujoco.mjtJoint.mjJNT_SLIDE.value
_ALONG = 1e-4  # sine of the angle between a tendon and a motion along it
_NOT_COPIED = ("name", "path", "id", "info", "signature", "default", "compiler")

Path = Sequence[mujoco.MjsWrap]


def split_guides(spec: mujoco.MjSpec, pieces: int) -> mujoco.MjModel:
    """Compile a model, which is changed, with every guide of a sheath in ``pieces`` ≥ 2.

    Sites next to each other on one rigid body stand for a stretch of sheath, and share its bend.
    Each is replaced by sites on the body that bend by equal parts, spread over half of the way to
    its neighbours. The path's length and its direction at the ends stay as they are. A site that is
    alone on its body is an eyelet and stays one, and so does one whose neighbour moves otherwise
    than along the tendon. Geoms get more `arc_guides`. A cable that is not
    drawn keeps its one guide.
    """
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    for name, plugin in sheaths_by_tendon(spec).items():
        config, tendon = dict(plugin.config), spec.tendon(name)
        path = list(tendon.path)
        if path[0].type == _JOINT:
            continue
        undrawn = float(config.get("extra_bend", 0.0)) != 0.0
        runs = [_split(model, data, path, run, pieces, undrawn) for run in _runs(model, data, path)]
        arcs, arc_guides = sum(_is_geom(p) for p in path), int(config.get("arc_guides", 1))
        added = sum(len(points) - len(run) for run, points in runs)
        if arcs:
            config["arc_guides"] = str(arc_guides * pieces)
            added += arcs * arc_guides * (pieces - 1)
        if "guides" in config:
            config["guides"] = str(int(config["guides"]) + added)
        _replace_path(spec, data, tendon, runs)
        plugin.config = config
    return spec.compile()


def _is_geom(point: mujoco.MjsWrap) -> bool:
    return point.type not in (_SITE, _PULLEY)


def _runs(model: mujoco.MjModel, data: mujoco.MjData, path: Path) -> list[range]:
    """Places in a path of sites that follow each other and can be split, two or more a run."""
    runs: list[range] = []
    for k in range(1, len(path) - 1):
        around = path[k - 1 : k + 2]
        if not all(p.type == _SITE for p in around):
            continue
        if not all(_keeps_heading(model, data, path[k], path[j]) for j in (k - 1, k + 1)):
            continue
        if runs and runs[-1].stop == k and _body(model, path[k]) == _body(model, path[k - 1]):
            runs[-1] = range(runs[-1].start, k + 1)
        else:
            runs.append(range(k, k + 1))
    return [run for run in runs if len(run) > 1]


def _body(model: mujoco.MjModel, site: mujoco.MjsWrap) -> int:
    """Number of the rigid body that a site of a path is on."""
    return int(model.body_weldid[model.site(site.target.name).bodyid[0]])


def _keeps_heading(
    model: mujoco.MjModel, data: mujoco.MjData, one: mujoco.MjsWrap, other: mujoco.MjsWrap
) -> bool:
    """Return whether two sites of a path lie apart, and move along their line alone, or as one."""
    at = [data.site(p.target.name) for p in (one, other)]
    way = at[1].xpos - at[0].xpos
    length = float(np.linalg.norm(way))
    if not length > 0.0 or _body(model, one) == _body(model, other):
        return length > 0.0
    jacobian = np.zeros((2, 3, model.nv))
    for k, site in enumerate(at):
        mujoco.mj_jacSite(model, data, jacobian[k], None, site.id)
    relative = jacobian[1] - jacobian[0]
    speed = np.linalg.norm(relative, axis=0)
    across = relative - np.outer(way, way @ relative) / length**2
    slides = model.jnt_type[model.dof_jntid] == _SLIDE
    rests = speed <= ROUNDING
    return bool((rests | slides & (np.linalg.norm(across, axis=0) <= _ALONG * speed)).all())


def _split(
    model: mujoco.MjModel, data: mujoco.MjData, path: Path, run: range, pieces: int, undrawn: bool
) -> tuple[range, FloatArray]:
    """Places in a path, and the sites (k, 3) to be put there in place of a run [m].

    An end of the tendon on the body of the run moves over so that the others lie where they should.
    Else the end of the run stays, and legs change as little as this needs.
    """
    places = range(run.start - 1, run.stop + 1)
    points = np.array([data.site(path[k].target.name).xpos for k in places])
    own = _body(model, path[run.start])
    moves = [_body(model, path[k]) != own for k in (places[0], places[-1])]
    ends = places[0] == 0 and not moves[0], places[-1] == len(path) - 1 and not moves[1]
    headings, legs = _legs(points, pieces, undrawn)
    if not any(ends):
        length = float(legs.sum())
        rows = np.column_stack([headings, np.ones(legs.size)]).T * legs
        lacking = np.append(points[-1] - points[0], length) - rows.sum(axis=1)
        change = np.linalg.lstsq(rows, lacking, rcond=None)[0]
        if np.abs(rows @ change - lacking).max() > ROUNDING * length or (change <= -1.0).any():
            return run, points[1:-1]
        legs *= 1.0 + change
    corners = points[0] + np.vstack([np.zeros(3), np.cumsum(headings * legs[:, None], axis=0)])
    if ends[0]:
        corners += points[-1] - corners[-1]
        return range(run.stop), corners[:-1]
    return (range(run.start, len(path)), corners[1:]) if ends[1] else (run, corners[1:-1])


def _legs(points: FloatArray, pieces: int, undrawn: bool) -> tuple[FloatArray, FloatArray]:
    """Headings (k, 3) and lengths (k,) of a path of which each corner is split in its place [m].

    Pieces of a corner have the same bend and distance. What does not turn is a corner only if all
    guides share a bend that is ``undrawn``.
    """
    ways = np.diff(points, axis=0)
    lengths = np.linalg.norm(ways, axis=1)
    ways /= lengths[:, None]
    headings, legs = [ways[0]], [float(lengths[0])]
    for k, (came, goes) in enumerate(pairwise(ways)):
        nearest = [0.5 * lengths[j] for j in (k, k + 1) if 0 < j < len(ways) - 1]
        reach = min(*nearest, lengths[k], lengths[k + 1])
        angle = float(np.arctan2(np.linalg.norm(np.cross(came, goes)), came @ goes))
        turns = ROUNDING < angle < np.pi - ROUNDING  # and does not fold back
        count = pieces if turns or (undrawn and angle <= ROUNDING) else 1
        legs[-1] -= reach * (1.0 - 1.0 / count)
        for j in range(1, count):
            shares = np.array([count - j, j]) / count
            weights = np.sin(shares * angle) / np.sin(angle) if turns else shares
            headings.append(weights @ (came, goes))
            legs.append(2.0 * reach / count)
        headings.append(goes)
        legs.append(float(lengths[k + 1]) - reach * (1.0 - 1.0 / count))
    return np.array(headings), np.array(legs)


def _replace_path(
    spec: mujoco.MjSpec,
    data: mujoco.MjData,
    tendon: mujoco.MjsTendon,
    runs: Sequence[tuple[range, FloatArray]],
) -> None:
    """Put another tendon of the same name in the place of one, with other sites in its runs."""
    name, path = tendon.name, list(tendon.path)
    tendon.name = f"{name} of fewer guides"  # what refers to the name means the new one
    new = spec.add_tendon(name=name)
    for attribute in dir(tendon):
        if not attribute.startswith(("_", "wrap_")) and attribute not in _NOT_COPIED:
            setattr(new, attribute, getattr(tendon, attribute))
    split = {k: points if k == run.start else () for run, points in runs for k in run}
    for k, point in enumerate(path):
        if point.type == _PULLEY:
            new.wrap_pulley(point.divisor)
        elif _is_geom(point):
            new.wrap_geom(point.target.name, point.sidesite.name if point.sidesite else "")
        elif k not in split:
            new.wrap_site(point.target.name)
        else:
            parent, body = point.target.parent, data.model.site(point.target.name).bodyid[0]
            turn = data.xmat[body].reshape(3, 3).T
            for j, place in enumerate(split[k]):
                site = f"{name} {k} {j}"
                parent.add_site(name=site, pos=turn @ (place - data.xpos[body]))
                new.wrap_site(site)
    spec.delete(tendon)
