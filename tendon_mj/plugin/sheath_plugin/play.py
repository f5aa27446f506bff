"""Play between joints and the drums and pulleys on which cables wind.

    q − b (1 − s)/2 ≤ p ≤ q + b (1 + s)/2,   Σ_i M_i(p) = 0 between the flanks

A drum or pulley p has no mass: it turns to where the torques M_i of its cables balance, or to the
flank of its joint q that bears them. On a flank what they do not balance acts on the joint, and
between the flanks nothing does. Each M_i grows with p, for guides that hold or slide from the last
step on, so that there is one such place; the Illinois method finds it. Drums and pulleys that share
cables are turned one after the other until none moves. The play b of a pulley is the largest that
one of its cables states, and s, the mean of theirs, says on which flank the joint is where p = q:
that of a load in the reference pose.
"""

from __future__ import annotations

import math
from typing import Any

from tendon_mj.native import apart, compiled
from tendon_mj.plugin.abi.layout import Data, Model
from tendon_mj.plugin.abi.library import free, malloc
from tendon_mj.plugin.abi.memory import words
from tendon_mj.plugin.sheath_plugin import drive
from tendon_mj.plugin.sheath_plugin.attributes import is_sheath
from tendon_mj.plugin.sheath_plugin.bind import ensure_bound, is_bound
from tendon_mj.plugin.sheath_plugin.forces import add_torque
from tendon_mj.plugin.sheath_plugin.state import State, has_play, state_at, state_of, unpack
from tendon_mj.plugin.sheath_plugin.strain import spool_torque, unstretched
from tendon_mj.plugin.sheath_plugin.wound import evaluate_wound, is_ready, solve_wound

_SWEEPS = 30  # over drums and pulleys that share cables
_TRIALS = 60  # of the Illinois method; about 8 are needed
_BALANCED = 1e-13  # of the torques of all cables
_STILL = 1e-13  # rad or m that a drum or pulley moves in a sweep


@apart
def evaluate_with_play(m: Model, d: Data, instance: int) -> None:
    """Evaluate all sheaths that wind on drums or pulleys with play, with the last of them."""
    for other in range(instance + 1, m.nplugin):
        is_ours = is_sheath(m, other, instance) and ensure_bound(m, d, other)
        if is_ours and has_play(state_at(state_of(m, d, other))):
            return
    block = malloc(8 * (instance + 1))
    addresses, count = words(block), 0
    for other in range(instance + 1):
        if is_sheath(m, other, instance) and is_bound(m, d, other):
            address = state_of(m, d, other)
            if has_play(state_at(address)) and is_ready(m, d, address):
                addresses[count] = address
                count += 1
    _balance(m, d, addresses, count)
    for k in range(count):
        evaluate_wound(m, d, addresses[k])
    _free_joints(m, d, addresses, count)
    free(block)


@compiled
def _balance(m: Model, d: Data, addresses: Any, count: int) -> None:
    """Turn all drums and pulleys to where their cables balance, or to a flank."""
    for _ in range(_SWEEPS):
        moved, turned = 0.0, 0
        for k in range(count):
            state = state_at(addresses[k])
            for at_reel in (True, False):
                joint = state.reel_joint if at_reel else state.output_joint
                if _first_on(addresses, count, joint, at_reel) == k:
                    moved = max(moved, _turn(m, d, addresses, count, k, at_reel))
                    turned += 1
        if turned < 2 or not moved > _STILL:
            break


@compiled
def _play_of(state: State, joint: float, at_reel: bool) -> float:
    """Play of a sheath on the drum, or pulley, of a joint; 0 if it does not wind on it with any."""
    if joint < 0.0 or joint != (state.reel_joint if at_reel else state.output_joint):
        return 0.0
    return state.reel_play if at_reel else state.output_play


@compiled
def _first_on(addresses: Any, count: int, joint: float, at_reel: bool) -> int:
    """The first sheath on the drum or pulley of a joint, −1 without one."""
    for k in range(count):
        if _play_of(state_at(addresses[k]), joint, at_reel) > 0.0:
            return k
    return -1


@compiled
def _torque(address: int, at_reel: bool) -> float:
    """Torque by which a cable turns its drum, or pulley, back."""
    state = state_at(address)
    if at_reel:
        return state.reel_torque
    segments, guides, _ = unpack(address)
    return spool_torque(state, segments, len(guides), state.output_radius)


@compiled
def _torque_at(
    m: Model, d: Data, addresses: Any, count: int, joint: float, at_reel: bool, angle: float
) -> tuple[float, float]:
    """Torque of all cables on a drum or pulley at an angle, and the sum of the sizes of each.

    The sheaths are left as they are solved there.
    """
    net = size = 0.0
    for k in range(count):
        state = state_at(addresses[k])
        if not _play_of(state, joint, at_reel) > 0.0:
            continue
        if at_reel:
            state.drum = angle
        else:
            state.pulley = angle
        unsolved = state.unsolved
        solve_wound(m, d, addresses[k])
        state.unsolved = unsolved
        torque = _torque(addresses[k], at_reel)
        net += torque
        size += abs(torque)
    return net, size


@compiled
def _flanks(
    m: Model, d: Data, addresses: Any, count: int, joint: float, at_reel: bool
) -> tuple[float, float]:
    """Between which angles a joint lets its drum or pulley turn."""
    play = rest = sheaths = 0.0
    for k in range(count):
        state = state_at(addresses[k])
        own = _play_of(state, joint, at_reel)
        if own > 0.0:
            play = max(play, own)
            rest += 0.0 if at_reel else state.output_rest
            sheaths += 1.0
    rest = min(max(rest / sheaths, -1.0), 1.0)
    angle = drive.turned(m, d, joint)
    return angle - 0.5 * play * (1.0 - rest), angle + 0.5 * play * (1.0 + rest)


@compiled
def _free_joints(m: Model, d: Data, addresses: Any, count: int) -> None:
    """Take off each joint between its flanks what its cables have left of their balance.

    That is rounding, but for drums right before guides: where the tendon between has no length the
    torques change by a step, and no angle balances them.
    """
    for k in range(count):
        state = state_at(addresses[k])
        for at_reel in (True, False):
            joint = state.reel_joint if at_reel else state.output_joint
            if _first_on(addresses, count, joint, at_reel) != k:
                continue
            low, high = _flanks(m, d, addresses, count, joint, at_reel)
            if not low < (state.drum if at_reel else state.pulley) < high:
                continue
            for other in range(count):
                its = state_at(addresses[other])
                if its.applied != 0.0 and _play_of(its, joint, at_reel) > 0.0:
                    add_torque(m, d, joint, _torque(addresses[other], at_reel))


@compiled
def _last_angle(state: State, at_reel: bool, angle: float) -> float:
    """Where a drum or pulley stood after the last step; an ``angle`` before the first."""
    wound, radius = state.wound_out, state.output_radius
    if at_reel:
        wound, radius = state.wound_in, state.reel_radius
    return wound / unstretched(state, radius) if state.finished * radius != 0.0 else angle


@compiled
def _turn(m: Model, d: Data, addresses: Any, count: int, first: int, at_reel: bool) -> float:
    """Turn a drum or pulley; return by how much it has moved since it was turned last."""
    state = state_at(addresses[first])
    joint = state.reel_joint if at_reel else state.output_joint
    before = state.drum if at_reel else state.pulley
    angle = drive.turned(m, d, joint)
    low, high = _flanks(m, d, addresses, count, joint, at_reel)
    # from where it was last, as a rule on the same flank
    one = before if before != angle else _last_angle(state, at_reel, angle)
    one = min(max(one, low), high)
    net, size = _torque_at(m, d, addresses, count, joint, at_reel, one)
    other = low if net > 0.0 else high
    if one == other or not abs(net) > _BALANCED * size:
        return abs(one - before)
    beyond, size = _torque_at(m, d, addresses, count, joint, at_reel, other)
    if not net * beyond < 0.0:
        return abs(other - before)
    for _ in range(_TRIALS):
        between = 0.5 * (one + other)  # where a flank would take more tendon than there is
        if math.isfinite(beyond - net):
            between = other - beyond * (other - one) / (beyond - net)
        if between in (one, other):
            break
        found, size = _torque_at(m, d, addresses, count, joint, at_reel, between)
        if found * beyond < 0.0:
            one, net = other, beyond
        else:
            net *= 0.5
        other, beyond = between, found
        if not abs(found) > _BALANCED * size:
            break
    return abs(other - before)
