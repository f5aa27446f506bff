"""The plan of a sweep on disk, which says whether results in a folder are this sweep's."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path

from tendon_mj.errors import InvalidValueError
from tendon_mj.lab.recordings import Recording
from tendon_mj.whole_file import whole_file

Plan = Mapping[str, object]
BATCH = "rollouts a task"  # may differ: it changes no number


def read_plan(path: Path) -> Plan | None:
    """The plan in a file; None where there is none.

    Raises:
        InvalidValueError: it cannot be read.
    """
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
    except (FileNotFoundError, NotADirectoryError):
        return None
    except (OSError, ValueError, RecursionError) as error:
        raise InvalidValueError(
            f"{path} cannot be read ({error}); give another --out, or --again to begin anew"
        ) from error
    return found if isinstance(found, dict) else {}


def write_plan(path: Path, plan: Plan) -> None:
    """Write a plan, before its first result."""
    with whole_file(path) as made:
        made.write_text(json.dumps(plan, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")


def check_plan(path: Path, found: Plan, wanted: Plan) -> None:
    """Refuse to go on with another sweep than the one that was begun.

    Raises:
        InvalidValueError: names the first difference, with both values.
    """
    plain = json.loads(json.dumps(wanted))
    for name in [*plain, *found]:
        there, here = found.get(name), plain.get(name)
        if name != BATCH and there != here:
            raise InvalidValueError(
                f"{path.parent} holds another sweep: {name} is {there} there and {here} here; give"
                " another --out, or --again to begin anew"
            )


def plan_digest(plan: Plan) -> str:
    """16 hexadecimal digits of a plan."""
    return hashlib.sha256(json.dumps(plan).encode()).hexdigest()[:16]


def recording_digest(recording: Recording) -> str:
    """16 hexadecimal digits of what a recording drives and measures."""
    whole = hashlib.sha256(recording.time.tobytes() + repr(sorted(recording.hold)).encode())
    read = {column: measured.sensor for column, measured in recording.measured.items()}
    for name, element in [*recording.driven, *read.items()]:
        whole.update(f"{name} {element}".encode())
        whole.update(recording.columns[name].tobytes())
    return whole.hexdigest()[:16]
