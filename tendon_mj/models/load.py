"""Loading of models by name, those of the package or any MJCF file, and their digest.

MuJoCo 3.17 crashes where a `<replicate>` copies a sensor or an actuator that refers to a plugin
instance by name: it goes through the list of instances to which it adds. It copies those whose
object is copied, and sensors without an object always. Such models are refused from their text.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Iterator
from pathlib import Path

import mujoco
import numpy as np

from tendon_mj.attach import Element, Mjcf
from tendon_mj.errors import TendonError, UnknownNameError
from tendon_mj.model_files import files_of_model

# In a wheel the models lie in this folder, in a checkout next to the package.
_FOLDERS = (Path(__file__).parent, Path(__file__).parents[2] / "models")
_OURS = "tendon_mj."  # begins the names of the plugins
_ROOT = re.compile(rb"<mujoco[\s>]")  # and not of included files
_REFERS = {  # attribute, or type of object → tag of the named element
    **{key: key for key in ("site", "geom", "joint", "tendon", "body")},
    **dict.fromkeys(("sidesite", "cranksite", "slidersite", "refsite"), "site"),
    "jointinparent": "joint",
    "xbody": "body",
}
_MJCF = (".xml", ".mjcf")  # of models in a model, and of their includes


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
    if beside is None:
        names += map(str, path.parent.glob("*.xml"))
    else:
        names += [file.name for file in beside.glob("*.xml")]
        where = f"searched {beside.resolve()}, next to the description, and the package's models"
    raise UnknownNameError("model or MJCF file", name, names, where)


def load_spec(name: str, *, scene: bool = False, beside: Path | None = None) -> mujoco.MjSpec:
    """A model as an editable `MjSpec`; see ``model_path`` for the arguments.

    Raises:
        UnknownNameError: no such model.
        TendonError: MuJoCo cannot read it; the message is MuJoCo's, with the file's name. Or it
            copies a sheath in a `<replicate>`, where MuJoCo crashes.
    """
    path = model_path(name, scene=scene, beside=beside)
    _check_replicated(path)
    try:
        return mujoco.MjSpec.from_file(str(path))
    except ValueError as error:
        no_model = "decoder" in str(error)  # of a file that is neither XML nor what plugins read
        hint = "; a model is an MJCF or a URDF file, such as hand.xml" if no_model else ""
        raise TendonError(f"{path}: {error}{hint}") from error


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


def _check_replicated(path: Path) -> None:
    """Refuse a model in which MuJoCo would copy a reference to a sheath, before MuJoCo reads it."""
    files = (file for file in files_of_model(path) if file == path or file.suffix in _MJCF)
    texts = {file: file.read_bytes() for file in files}
    together = b"".join(texts.values())
    if b"<replicate" not in together or _OURS.encode() not in together:
        return
    for file, text in texts.items():
        if not _ROOT.search(text):
            continue
        try:
            root = Mjcf(file).root
        except (TendonError, OSError, ValueError) as error:  # MuJoCo may read it all the same
            raise TendonError(
                f"{error}; a model with <replicate> must be UTF-8 XML so that it can be checked, as"
                " MuJoCo may crash where it copies a sheath"
            ) from None
        copied = _copied(root)
        for kind, element in _shown(root) if copied else ():
            _check_copied(f"{file}: {kind} {element.get('name', '')!r}", kind, element, copied)


def _copied(root: Element) -> set[tuple[str, str | None]]:
    """Tag and name of elements that a `<replicate>` copies; of tendons those with a copied part."""
    copied = {(e.tag, e.get("name")) for copies in root.iter("replicate") for e in copies.iter()}
    for tendon in root.iterfind("tendon/*"):
        if any(copied & _referred(part) for part in tendon):
            copied.add(("tendon", tendon.get("name")))
    return copied


def _shown(root: Element) -> Iterator[tuple[str, Element]]:
    """Sensors and actuators that refer to an instance of our plugins, each with its kind."""
    ours = {
        instance.get("name")
        for plugin in root.iterfind("extension/plugin")
        if plugin.get("plugin", "").startswith(_OURS)
        for instance in plugin.iterfind("instance")
    }
    for kind in ("sensor", "actuator"):
        for element in root.iterfind(f"{kind}/plugin"):
            if element.get("instance") in ours:
                yield kind, element


def _check_copied(
    where: str, kind: str, element: Element, copied: set[tuple[str, str | None]]
) -> None:
    if kind == "sensor" and element.get("objname") is None:
        raise TendonError(
            f"{where} shows a sheath and has no object; MuJoCo copies such a sensor in each"
            ' <replicate>, and crashes: give it objtype="tendon" and the tendon\'s name as objname'
        )
    for tag, name in sorted(copied & _referred(element)):
        raise TendonError(
            f"{where} is on {tag} {name!r}, which a <replicate> copies with it; MuJoCo may crash"
            " over the copies of its plugin instance: leave it out, give the copies friction in"
            " Python, with tendon_mj.add_friction, and write them with MjSpec.to_xml"
        )


def _referred(element: Element) -> set[tuple[str, str | None]]:
    """Tag and name of the elements to which part of a path, a sensor or an actuator refers."""
    referred = {(_REFERS[key], name) for key, name in element.attrib.items() if key in _REFERS}
    kind = element.get("objtype", "")
    return {*referred, (_REFERS.get(kind, kind), element.get("objname", ""))}
