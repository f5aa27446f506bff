"""Loading of models by name, those of the package or any MJCF file, and their digest."""

from __future__ import annotations

import hashlib
from pathlib import Path

import mujoco
import numpy as np

from tendon_mj.errors import TendonError, UnknownNameError

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
    return sorted(name for name, file in _files().items() if name == file.parent.name)


def _files() -> dict[str, Path]:
    """MJCF files of the package's models and their variants, as `finger_spring`, by name."""
    folders = [scene.parent for scene in models_folder().glob("*/scene.xml")]
    return {file.stem: file for folder in folders for file in folder.glob(f"{folder.name}*.xml")}


def model_path(name: str, *, scene: bool = False, beside: Path | None = None) -> Path:
    """The MJCF file of a model: ``<name>.xml``, or ``scene.xml`` with light and floor.

    Args:
        name: of a model that comes with the package, or of a variant of one (`finger_spring`); or
            the path of an MJCF file.
        scene: whether the scene around it is wanted too.
        beside: folder of the description that names it, for the message.

    Raises:
        UnknownNameError: neither a model of the package nor a file; with the places searched.
    """
    files, path = _files(), Path(name)
    if name in files:
        file = files[name]
        shown = f"scene{name.removeprefix(file.parent.name)}.xml"
        return file.with_name(shown) if scene else file
    if path.is_file():
        return path
    names, where = list(files), ""
    if beside is not None:
        names += [file.name for file in beside.glob("*.xml")]
        where = f"searched {beside.resolve()}, next to the description, and the package's models"
    raise UnknownNameError("model or MJCF file", name, names, where)


def load_spec(name: str, *, scene: bool = False, beside: Path | None = None) -> mujoco.MjSpec:
    """A model as an editable `MjSpec`; see ``model_path`` for the arguments.

    Raises:
        UnknownNameError: no such model.
        TendonError: MuJoCo cannot read it; the message is MuJoCo's, with the file's name.
    """
    path = model_path(name, scene=scene, beside=beside)
    try:
        return mujoco.MjSpec.from_file(str(path))
    except ValueError as error:
        raise TendonError(f"{path}: {error}") from error


def load_model(name: str, *, scene: bool = False, beside: Path | None = None) -> mujoco.MjModel:
    """A compiled model; see ``load_spec``."""
    spec = load_spec(name, scene=scene, beside=beside)
    try:
        return spec.compile()
    except ValueError as error:
        path = model_path(name, scene=scene, beside=beside)
        raise TendonError(f"{path}: {error}") from error


def model_digest(model: mujoco.MjModel) -> str:
    """16 hexadecimal digits of a compiled model's content, by which processes compare theirs."""
    content = np.empty(mujoco.mj_sizeModel(model), np.uint8)
    mujoco.mj_saveModel(model, None, content)
    return hashlib.sha256(content.tobytes()).hexdigest()[:16]
