"""The path of a tendon in a spec, against the model that MuJoCo compiles."""

import mujoco
import pytest

from tendon_mj.attach.tendons import path_of

RIG = """
<mujoco>
  <worldbody>
    <geom name="ball" size=".01"/><geom name="drum" type="cylinder" size=".01 .1"/>
    <site name="a"/><site name="b" pos=".1 0 0"/><site name="c" pos=".1 .1 0"/>
    <body><joint name="j"/><geom size=".01"/></body>
  </worldbody>
  <tendon>{}</tendon>
</mujoco>
"""
SITES = [f'<site site="{name}"/>' for name in "abc"]
BALL, DRUM = '<geom geom="ball"/>', '<geom geom="drum" sidesite="c"/>'
PULLEY = '<pulley divisor="2"/>'
A, B, C = SITES

PATHS = {
    A + B: ([("ab", 0)], 0),
    A + B + C: ([("abc", 0)], 1),
    A + BALL + B: ([("ab", 1)], 3),
    A + BALL + B + DRUM + C: ([("abc", 2)], 7),
    A + B + PULLEY + B + C: ([("ab", 0), ("bc", 0)], 1),
    A + DRUM + B + PULLEY + B + C + A: ([("ab", 1), ("bca", 0)], 5),
}


FIXED = '<fixed name="t"><joint joint="j" coef="1"/></fixed>'


def tendon(path):
    text = path if path == FIXED else f'<spatial name="t">{path}</spatial>'
    spec = mujoco.MjSpec.from_string(RIG.format(text))
    return spec.tendon("t"), spec


@pytest.mark.parametrize("path", PATHS)
def test_guides_are_inner_sites_arcs_and_pulleys_before_and_after_compiling(path):
    branches, guides = PATHS[path]
    element, spec = tendon(path)
    before = path_of(element)
    assert before.is_spatial
    assert [("".join(sites), wraps) for sites, wraps in before.branches] == branches
    assert before.ends() == [(sites[0], sites[-1]) for sites, _ in branches]
    assert before.guides(3) == guides
    model = spec.compile()
    assert path_of(element) == before
    assert model.nwrap == sum(len(sites) + wraps for sites, wraps in branches) + len(branches) - 1


def test_more_guides_on_an_arc_are_more_for_every_wrap():
    path = path_of(tendon(A + BALL + B + DRUM + C)[0])
    assert [path.guides(n) for n in (1, 2, 5)] == [3, 5, 11]


def test_a_fixed_tendon_is_not_spatial():
    element, _ = tendon(FIXED)
    assert not path_of(element).is_spatial
    assert path_of(element).ends() == [("", "")]
