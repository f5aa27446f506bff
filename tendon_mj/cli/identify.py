"""`tendon-mj identify`: what columns and a motion can tell, before anything is recorded."""

from __future__ import annotations

from pathlib import Path

from tendon_mj.cli.diagnose import read_one
from tendon_mj.cli.options import Recordings, Repeated, flat, given_files
from tendon_mj.cli.output import Output, console, print_table, progress_bar
from tendon_mj.errors import RecordingError
from tendon_mj.lab.diagnosis import Identifiability
from tendon_mj.lab.diagnosis import identify as judge
from tendon_mj.lab.experiment import planned_recording, read_bounds
from tendon_mj.lab.recordings import Recording, table_beside
from tendon_mj.lab.units import quantity


def identify(
    recordings: Recordings,
    out: Path = Path("out/identify"),
    signals: Repeated[str] = (),
    description: Path | None = None,
    model: str | None = None,
    bounds: Path | None = None,
) -> dict[str, object]:
    """Say which numbers and effects columns can tell in a motion, before anything is recorded.

    Args:
        recordings: Tables of the rig's motions, of which only the driven columns count, or a
            description (TOML) without a table, for the motion of --bounds.
        out: Folder for result.json.
        signals: Measured columns that would be recorded. By default all of the description; the
            others are proposed if they decide between effects that these cannot tell apart.
        description: TOML file that describes the columns of all recordings, with their noise.
        model: Model in place of the description's own: a name or an MJCF file.
        bounds: TOML file with the limits of the rig, as for --next of diagnose: growing loops up
            to these are the motion, and columns in [measure] are further ones.

    Example:
        tendon-mj identify rig.toml --bounds bounds.toml --signals lever_deg
    """
    given = [*given_files(recordings, description, [model]), bounds]
    output = Output(out, given=given)
    if not recordings:
        raise RecordingError("identify needs a recording or a description")
    read = [_motion(path, description, model, bounds) for path in recordings]
    with progress_bar() as progress:
        found = judge(read, flat(signals), progress=progress)
    _print(found)
    return output.finish(found.result(), found.sentence)


def _motion(
    path: Path, description: Path | None, model: str | None, bounds: Path | None
) -> Recording:
    """A recording of the motion: a table, or the motion that is planned within bounds."""
    if bounds is not None:
        return planned_recording(path, read_bounds(bounds), model)
    if path.suffix.lower() == ".toml" and not table_beside(path)[0].is_file():
        raise RecordingError(
            f"{path}: no table with a motion is beside it; plan one with --bounds TOML, or give a"
            " table and --description"
        )
    return read_one(path, description, model, None)


def _print(found: Identifiability) -> None:
    """Print the numbers, the effects and the pairs that are not told apart."""
    rows = []
    for one in found.numbers:
        value, half, then = (quantity(v, one.unit) for v in (one.value, one.half, one.half_then))
        sure = "determined" if one.determined else "not determined"
        unless = f", ± {then} if there may be {one.unless}" if one.unless else ""
        rows.append([one.name, value, f"± {half}", sure + unless])
    print_table(["uncertain number", "value", "95 % within", ""], rows)
    place, rows = {effect.label: k for k, effect in enumerate(found.effects, 1)}, []
    for effect in found.effects:
        pairs = [p.effects for p in found.pairs if p.below is None]
        others = sorted(place[other] for one, other in pairs if one == effect.label)
        strengths = [
            "–" if value is None else quantity(value, effect.unit)
            for value in (effect.noticed, effect.named)
        ]
        listed = ", ".join(map(str, others))
        rows.append([f"{place[effect.label]} {effect.label}", *strengths, listed])
    print_table(["effect", "noticed from", "named from", "taken for"], rows)
    for text in dict.fromkeys(pair.decided_by for pair in found.untold):
        pairs = [p.effects for p in found.untold if p.decided_by == text]
        listed = ", ".join(f"{place[one]} and {place[other]}" for one, other in pairs)
        console.print(f"To decide between {listed}: {text}.")
