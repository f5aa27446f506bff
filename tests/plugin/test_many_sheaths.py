"""A model with many sheaths: what the checks read grows with their number, not its square."""

import mujoco
import pytest

from tendon_mj import add_friction, add_sites, add_tendon
from tendon_mj.plugin import sheaths
from tendon_mj.plugin.abi.checks import Draft


def rig(count):
    """So many tendons over the same three sites, each in a sheath with its sensors."""
    spec = mujoco.MjSpec()
    sites = add_sites(spec, "site", [[0, 0, 0], [1, 0, 0], [1, 1, 0]])
    for k in range(count):
        add_tendon(spec, f"t{k}", sites)
        add_friction(spec, f"t{k}", friction=0.1, axial_stiffness=1e3, pretension=1.0)
    return spec


@pytest.fixture
def reads(monkeypatch):
    """Every call with which a check reads a name or a configuration."""
    seen = []

    def counting(read):
        def counted(self, *arguments):
            seen.append(arguments)
            return read(self, *arguments)

        return counted

    for method in ("config", "name", "plugin"):
        monkeypatch.setattr(Draft, method, counting(getattr(Draft, method)))
    return seen


def test_each_more_sheath_costs_as_many_reads_as_the_one_before(reads):
    counts = []
    for count in (10, 20, 40):
        reads.clear()
        mujoco.MjData(rig(count).compile())
        counts.append(len(reads))
    assert counts[2] - counts[1] == 2 * (counts[1] - counts[0])


def test_models_compiled_in_turn_do_not_see_each_other():
    for count in (3, 1, 5, 2):
        model = rig(count).compile()
        assert len(sheaths(model)) == count
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        names = [model.sensor(k).name for k in range(model.nsensor)]
        assert [float(data.sensor(n).data[0]) for n in names] == pytest.approx([1.0] * len(names))
