"""Sheaths on MuJoCo Warp: thousands of worlds at once, on a GPU or, slowly, on the CPU."""

from __future__ import annotations

from tendon_mj.errors import MissingPackageError

_OLDEST = (3, 11)

try:
    import mujoco_warp as _mujoco_warp

    if tuple(int(part) for part in _mujoco_warp.__version__.split(".")[:2]) < _OLDEST:
        raise MissingPackageError(
            f"tendon_mj.warp needs mujoco-warp {'.'.join(map(str, _OLDEST))} or later, and "
            f"{_mujoco_warp.__version__} is installed: pip install --upgrade 'tendon-mj[warp]'",
            name="mujoco_warp",
        )
    from tendon_mj.warp.hosts import take_sheaths as take_sheaths
    from tendon_mj.warp.mjlab_terms import draw_parameters as draw_parameters
    from tendon_mj.warp.mjlab_terms import tension as tension
    from tendon_mj.warp.model import get_data_into as get_data_into
    from tendon_mj.warp.model import make_data as make_data
    from tendon_mj.warp.model import put_data as put_data
    from tendon_mj.warp.model import put_model as put_model
    from tendon_mj.warp.model import put_sheaths as put_sheaths
    from tendon_mj.warp.model import reset_data as reset_data
    from tendon_mj.warp.model import sheaths_of as sheaths_of
    from tendon_mj.warp.sheaths import Sheaths as Sheaths
except ModuleNotFoundError as error:
    package = str(error.name).partition(".")[0]
    if package not in ("warp", "mujoco_warp"):
        raise
    raise MissingPackageError(
        f"tendon_mj.warp needs {package}, which is not installed: pip install 'tendon-mj[warp]'",
        name=package,
    ) from None
