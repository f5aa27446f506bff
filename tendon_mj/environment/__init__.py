"""dm_control environments on the finger, a friction of its own in every episode.

Raises:
    MissingPackageError: dm-control or dm-env is not installed.
"""

from tendon_mj.errors import MissingPackageError

try:
    from tendon_mj.environment.finger import follow_trajectory as follow_trajectory
    from tendon_mj.environment.finger import hold_force as hold_force
    from tendon_mj.environment.physics import FingerPhysics as FingerPhysics
    from tendon_mj.environment.ranges import Ranges as Ranges
except ModuleNotFoundError as error:
    package = str(error.name).partition(".")[0]
    if package not in ("dm_control", "dm_env"):
        raise
    raise MissingPackageError(
        f"tendon_mj.environment needs {package}, which is not installed: "
        "pip install 'tendon-mj[environments]', and from Python 3.13 on also "
        "pip install --no-deps dm-control",
        name=package,
    ) from None
