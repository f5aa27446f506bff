"""The capstan law from a tenth of a turn to two whole turns: e^{±μφ} as the tendon slides.

MuJoCo wraps a tendon around one geom by less than a turn, so more comes by drums one behind the
other, or by bend that is not drawn.
"""

import math

import mujoco
import numpy as np
import pytest

from tendon_mj import add_friction, view_sheath

FRICTION, RADIUS, STRAIGHT = 0.2, 0.03, 0.05
TURNS = [10, 45, 90, 180, 270, 360, 450, 540, 630, 720]  # [deg]
PULLS = {"in": ((-20.0, 0.0), 1.0), "out": ((-5.0, 100.0), -1.0)}


def row_of_drums(turn, drums):
    """A spec: a tendon that turns by ``turn``/drums to the left on each drum, and pulls on a mass.

    Between two drums it runs straight over a site; the mass slides along its last stretch.
    """
    each, point, heading = turn / drums, np.zeros(2), 0.0
    sites, geoms = [point], []
    for _ in range(drums):
        along = np.array([math.cos(heading), math.sin(heading)])
        left = np.array([-along[1], along[0]])
        centre = point + STRAIGHT * along + RADIUS * left
        heading += each
        along = np.array([math.cos(heading), math.sin(heading)])
        out = np.array([along[1], -along[0]])
        middle = centre + 2.0 * RADIUS * np.array(
            [math.sin(heading - each / 2.0), -math.cos(heading - each / 2.0)]
        )
        point = centre + RADIUS * out + STRAIGHT * along
        geoms.append((centre, middle))
        sites.append(point)
    texts, path = [], ['<site site="s0"/>']
    for k, (centre, middle) in enumerate(geoms):
        texts.append(
            f'<geom name="g{k}" type="cylinder" size="{RADIUS} .01" pos="{centre[0]} {centre[1]}'
            f' 0" contype="0" conaffinity="0"/><site name="m{k}" pos="{middle[0]} {middle[1]} 0"/>'
        )
        path.append(f'<geom geom="g{k}" sidesite="m{k}"/><site site="s{k + 1}"/>')
    texts += [f'<site name="s{k}" pos="{p[0]} {p[1]} 0"/>' for k, p in enumerate(sites[:-1])]
    last = sites[-1]
    return mujoco.MjSpec.from_string(f"""<mujoco><option timestep="0.001" gravity="0 0 0"/>
      <worldbody>{"".join(texts)}
        <body pos="{last[0]} {last[1]} 0">
          <joint name="x" type="slide" axis="{along[0]} {along[1]} 0" damping="40"/>
          <geom size=".005" mass=".3" contype="0" conaffinity="0"/><site name="s{drums}"/></body>
      </worldbody>
      <tendon><spatial name="t">{"".join(path)}</spatial></tendon>
      <actuator><motor tendon="t"/><motor joint="x"/></actuator></mujoco>""")


def slide(spec, pull, **values):
    """View of the sheath some steps later, as the tendon slides steadily."""
    model = add_friction(spec, "t", friction=FRICTION, **values).compile()
    data = mujoco.MjData(model)
    data.ctrl[:] = pull
    mujoco.mj_step(model, data, 40)
    mujoco.mj_forward(model, data)
    return view_sheath(model, data, "t")


@pytest.mark.parametrize("arc_guides", [1, 4])
@pytest.mark.parametrize("way", PULLS)
@pytest.mark.parametrize("degrees", TURNS)
def test_drums_one_behind_the_other(degrees, way, arc_guides):
    pull, sense = PULLS[way]
    turn = math.radians(degrees)
    spec = row_of_drums(turn, drums=math.ceil(degrees / 90))
    view = slide(spec, pull, arc_guides=arc_guides)
    assert view.bend_angle.sum() == pytest.approx(turn, rel=1e-8)
    assert (view.slip[view.bend_angle > 1e-6] == sense).all()
    expected = math.exp(sense * FRICTION * view.bend_angle.sum())
    assert view.input_tension / view.output_tension == pytest.approx(expected, rel=1e-9)
    assert view.unsolved == 0


@pytest.mark.parametrize("inner_guides", [None, 3])
@pytest.mark.parametrize("way", PULLS)
@pytest.mark.parametrize("degrees", TURNS)
def test_a_drum_and_bend_that_is_not_drawn(degrees, way, inner_guides):
    pull, sense = PULLS[way]
    drawn = min(degrees, 90)
    more = math.radians(degrees - drawn)
    spec = row_of_drums(math.radians(drawn), drums=1)
    view = slide(spec, pull, extra_bend=more, inner_guides=inner_guides)
    expected = math.exp(sense * FRICTION * math.radians(degrees))
    assert view.input_tension / view.output_tension == pytest.approx(expected, rel=1e-9)
    assert view.unsolved == 0
