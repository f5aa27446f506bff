"""Page of a fleet: one HTML file with what changed, what differs, and a row for each rig."""

from __future__ import annotations

import base64
from collections.abc import Mapping, Sequence
from pathlib import Path

from tendon_mj.lab.diagnosis import Provenance
from tendon_mj.lab.fleet import FleetFound, RigFound
from tendon_mj.lab.replay import engineering_unit, plain, quantity
from tendon_mj.show.page.templates import templates

CHANGES, SPREAD = "changes", "spread"  # names of the pictures
_CAPTIONS = {
    CHANGES: "What changed, day by day: fitted to each recording by itself, everything else to all"
    " recordings of the rig. Bars are standard errors from noise.",
    SPREAD: "What was fitted to each rig, beside the median and the spread between rigs.",
}


def fleet_page(
    found: FleetFound, pictures: Mapping[str, bytes], provenance: Provenance, folder: str
) -> str:
    """The page as HTML. Every text that comes from a file is escaped.

    Args:
        found: of the fleet.
        pictures: name → PNG, of `changes` and `spread` those that there are.
        provenance: command, versions and date.
        folder: of the fleet, to name it.
    """
    return (
        templates(Path(__file__).parent)
        .get_template("fleet.html")
        .render(
            found=found,
            folder=folder,
            telling=[rig.sentence(found.units) for rig in found.with_findings],
            spreads=[
                (
                    name,
                    quantity(s.median, found.units[name]),
                    quantity(s.between, found.units[name]),
                )
                for name, s in found.spreads.items()
            ],
            heads=[_head(found, name) for name in found.units],
            rows=[_cells(found, rig) for rig in found.rigs],
            pictures=[
                (name, base64.b64encode(pictures[name]).decode("ascii"), _CAPTIONS[name])
                for name in (CHANGES, SPREAD)
                if name in pictures
            ],
            provenance=provenance,
        )
    )


def _unit_of(found: FleetFound, name: str) -> tuple[str, float]:
    chosen = engineering_unit(found.units[name], [found.spreads[name].median])
    return chosen.symbol, chosen.factor


def _head(found: FleetFound, name: str) -> str:
    symbol, _ = _unit_of(found, name)
    return f"{name} [{symbol or '-'}]"


def _cells(found: FleetFound, rig: RigFound) -> Sequence[str]:
    numbers = [
        plain(rig.values[name] * _unit_of(found, name)[1]) if name in rig.values else "–"
        for name in found.units
    ]
    days = f"{rig.dates[0]:%Y-%m-%d} … {rig.dates[-1]:%Y-%m-%d}" if rig.dates else "–"
    misfit, left = (plain(v, 2) if v == v else "–" for v in (rig.misfit, rig.left))
    return [rig.name, rig.verdict, str(len(rig.dates)), days, *numbers, misfit, left]
