"""What an instance's name shares with a tendon's, as Python and compiled code find it."""

import mujoco
from hypothesis import given
from hypothesis import strategies as st

from tendon_mj.plugin import sheaths
from tendon_mj.plugin.sheath_plugin.names import Affixes, around_tendon
from tendon_mj.plugin.sheath_plugin.state import view

AFFIX = st.text("ab", max_size=2)
FEW = st.text("ab", min_size=1, max_size=6)  # so that many fit by chance
MODEL = """
<mujoco>
  <extension><plugin plugin="tendon_mj.sheath"><instance name="{own}">
    <config key="tendon" value="{tendon}"/><config key="axial_stiffness" value="1000"/>
    <config key="friction" value=".1"/>
  </instance></plugin></extension>
  <worldbody>
    <site name="{prefix}x0{suffix}"/><site name="{prefix}x1{suffix}" pos=".2 0 0"/>
    <body><joint/><geom size=".1"/><site name="{prefix}x2{suffix}" pos=".3 .2 0"/></body>
  </worldbody>
  <tendon>{tendons}</tendon>
</mujoco>
"""


def all_shared(own: str, tendon: str, tendons: set[str]) -> list[Affixes]:
    """By trying every part of the name that `attach` may have added."""
    parts = [(end, start) for end in range(len(own)) for start in range(end + 1, len(own) + 1)]
    tried = [Affixes(own[:end], own[start:]) for end, start in parts]
    return [affixes for affixes in tried if affixes.around(tendon) in tendons]


@given(st.text("ab", max_size=6), FEW, st.sets(FEW, max_size=4))
def test_all_that_are_shared_are_found(own, tendon, tendons):
    assert around_tendon(own, tendon, tendons) == all_shared(own, tendon, tendons)


@given(AFFIX, AFFIX, FEW, FEW, st.sets(FEW, max_size=3))
def test_compiled_code_takes_the_tendon_that_python_takes(prefix, suffix, own, tendon, more):
    tendons = sorted(more | {prefix + tendon + suffix})
    model = compiled(own, Affixes(prefix, suffix), tendon, tendons)
    if model is None:
        return
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data)
    ((_, found),) = sheaths(model).items()
    bound = int(view(data.plugin_state, found.state).state.tendon)
    assert tendons[bound] == found.tendon


def compiled(own: str, affixes: Affixes, tendon: str, tendons: list[str]) -> mujoco.MjModel | None:
    """The model as attached with these; None if it is refused, as nothing says which is meant."""
    path = "".join(f'<site site="{affixes.around(site)}"/>' for site in ("x0", "x1", "x2"))
    text = MODEL.format(
        own=affixes.around(own),
        tendon=tendon,
        tendons="".join(f'<spatial name="{name}">{path}</spatial>' for name in tendons),
        **affixes._asdict(),
    )
    try:
        return mujoco.MjModel.from_xml_string(text)
    except ValueError as refused:
        if not any(reason in str(refused) for reason in ("may be", "unknown tendon")):
            raise
        return None
