"""Loading of models by name: those that come with the package, or any MJCF file."""

from __future__ import annotations

from pathlib import Path

import mujoco

from tendon_mj.errors import TendonError, UnknownNameError
from tendon_mj.model_files import files_of_model
from tendon_mj.models.replicated import check_replicated

# In a wheel the models lie in this folder, in a checkout next to the package.
_FOLDERS = (Path(__file__).parent, Path(__file__).parents[2] / "models")


def models_folder() -> Path:
    """The folder that holds one folder a model."""
    for folder in _FOLDERS:
        if (folder / "bench").is_dir():
            return folder
    raise TendonError(f"the models are missing: neither {_FOLDERS[0]} nor {_FOLDERS[1]} exists")


def example_recording() -> Path:
    """The CSV of a recording of the bench; it is simulated with lumped elements, not measured."""
    return models_folder() / "bench" / "recordings" / "twin.csv"


def example_rig() -> Path:
    """Folder of the rigs of docs/your_rig.md: model, description and simulated recordings."""
    return models_folder() / "rig"


def model_names() -> list[str]:
    """Names of the models that come with the package."""
    return sorted(p.parent.name for p in models_folder().glob("*/scene.xml"))


def model_path(name: str, *, scene: bool = False, beside: Path | None = None) -> Path:
    """The MJCF file of a model: ``<name>.xml``, or ``scene.xml`` with light and floor.

    Args:
        name: of a model that comes with the package, or of a variant of one (`finger_spring`); or
            the path of an MJCF file.
        scene: whether the scene around it is wanted too.
        beside: folder of the description that names it, if one does, in which it was sought first.

    Raises:
        UnknownNameError: neither a model of the package nor a file; it says where it was sought.
    """
    if name in model_names():
        return models_folder() / name / ("scene.xml" if scene else f"{name}.xml")
    path, variants = Path(name), _variants()
    if name in variants:
        variant = variants[name]
        shown = f"scene{name.removeprefix(variant.parent.name)}.xml"
        return variant.with_name(shown) if scene else variant
    if path.is_file():
        return path
    names, where = [*model_names(), *variants], ""
    if beside is not None:
        names += [file.name for file in beside.glob("*.xml")]
        where = (
            f"sought in {beside.resolve()}, beside the description, and among the package's models"
        )
    raise UnknownNameError("model or MJCF file", name, names, where)


def _variants() -> dict[str, Path]:
    """MJCF files of variants of the package's models by name, such as `finger_spring`."""
    files = models_folder().glob("*/*_*.xml")
    return {file.stem: file for file in files if file.stem.startswith(f"{file.parent.name}_")}


def load_spec(name: str, *, scene: bool = False, beside: Path | None = None) -> mujoco.MjSpec:
    """A model as an editable `MjSpec`; see ``model_path`` for the arguments.

    Raises:
        UnknownNameError: no such model.
        TendonError: MuJoCo cannot read it; the message is MuJoCo's, with the file's name. Or it
            copies a sheath in a `<replicate>`, where MuJoCo crashes.
    """
    path = model_path(name, scene=scene, beside=beside)
    check_replicated(path, files_of_model(path))
    try:
        return mujoco.MjSpec.from_file(str(path))
    except ValueError as error:
        raise TendonError(_refusal(path, error)) from error


def load_model(name: str, *, scene: bool = False, beside: Path | None = None) -> mujoco.MjModel:
    """A compiled model; see ``load_spec``."""
    path = model_path(name, scene=scene, beside=beside)
    try:
        return load_spec(name, scene=scene, beside=beside).compile()
    except ValueError as error:
        if isinstance(error, TendonError):
            raise
        raise TendonError(_refusal(path, error)) from error


def _refusal(path: Path, error: ValueError) -> str:
    if isinstance(error, UnicodeDecodeError):  # of a name, which MuJoCo takes as it stands
        byte = error.object[error.start]
        return f"{path}: a name has the byte 0x{byte:02x}, which is not UTF-8; save it as UTF-8"
    return f"{path}: {error}"
