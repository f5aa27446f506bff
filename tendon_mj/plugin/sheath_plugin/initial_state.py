"""The tendon at the first evaluation after a reset."""

from __future__ import annotations

from tendon_mj.compilation import apart
from tendon_mj.plugin.abi.layout import Layout
from tendon_mj.plugin.abi.memory import double, pointer
from tendon_mj.plugin.sheath_plugin.spools import wound_by
from tendon_mj.plugin.sheath_plugin.state import State
from tendon_mj.plugin.sheath_plugin.strain_law import reset_to_linear, rest_strain
from tendon_mj.sheath import Segments


@apart
def lay_tendon(layout: Layout, m: int, d: int, state: State, segments: Segments) -> None:
    """Lay the tendon evenly along its first path.

    Its unstretched length is fixed by the pretension in the reference pose `qpos0`, as MuJoCo fixes
    a spring length: S = (L(qpos0) + s)/(1 + ε_0) with a slack of s, and the tendon has crept as
    much as it will under it.
    """
    reference = double(pointer(m + layout.m_tendon_length0), int(state.tendon)) + state.law.slack
    strain, creep = rest_strain(state.law)
    unstretched = reference / (1.0 + strain + creep)
    if state.own_spring != 0.0:  # which may be another since the reset
        rest = double(pointer(m + layout.m_tendon_lengthspring), 2 * int(state.tendon) + 1)
        unstretched += rest - state.spring_length
        state.spring_length = rest
    state.wound_in = wound_by(layout, m, d, state.reel_joint, state.reel_radius)
    state.wound_out = wound_by(layout, m, d, state.output_joint, state.output_radius)
    unstretched -= state.wound_in + state.wound_out
    total = sum(segments["length"])
    strain = total / unstretched - 1.0 - creep
    for j in range(len(segments)):
        segment = segments[j]
        segment.stored = segment.length * unstretched / total
        segment.strain, segment.creep_strain = strain, creep
        segment.previous_tension = strain * (1.0 + state.law.stiffening * max(0.0, strain))
    reset_to_linear(segments)
    state.strain_kept = 1.0  # so that the strains just written count
    state.laid_pretension = state.law.pretension
    state.started = 1.0
