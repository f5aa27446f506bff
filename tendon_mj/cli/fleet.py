"""`tendon-mj fleet`: which of many rigs of one kind changed, in what, and since when."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import tyro

from tendon_mj.cli.output import Output, console, progress_bar, typed_command
from tendon_mj.errors import TendonError
from tendon_mj.lab.diagnosis import collect_provenance
from tendon_mj.lab.fleet import RESULT_TABLE, find_rigs, run_fleet
from tendon_mj.lab.tasks import Workers
from tendon_mj.show import CHANGES, SPREAD, changes_figure, fleet_page, spread_figure, write_table
from tendon_mj.whole_file import whole_file

PAGE = "fleet.html"


def fleet(
    folder: Annotated[Path, tyro.conf.Positional],
    out: Path = Path("out/fleet"),
    processes: int | None = None,
    workers: int | None = None,
    scheduler: str | None = None,
    again: bool = False,
) -> dict[str, object]:
    """Find which rig of many changed, in what and since when, and which differs from the others.

    Args:
        folder: a folder for each rig, with recordings named after their day, as 2026-03-03.csv,
            each with its TOML beside it, or with a description.toml for all.
        out: folder for the page, the table, result.json, and results of each rig, which the next
            run does not compute again.
        processes: of this machine, without Dask; default: as many as it has cores.
        workers: of a Dask cluster that lives as long as the run.
        scheduler: address of a Dask scheduler, such as tcp://10.0.0.1:8786.
        again: compute every rig again.

    Raises:
        TendonError: the folder is not a fleet, or no rig could be fitted; in the second case page
            and table have the reasons.

    Example:
        tendon-mj fleet hands --out out/hands
    """
    on = Workers(processes=processes, workers=workers, scheduler=scheduler)
    kept = out / "rigs"
    rigs = find_rigs(folder, kept)
    writes = (PAGE, RESULT_TABLE, f"{CHANGES}.png", f"{SPREAD}.png")
    output = Output(out, tables=(RESULT_TABLE,), writes=writes, begin=False)
    with progress_bar() as progress:
        result = run_fleet(rigs, kept, on=on, again=again, begin=output.begin, progress=progress)
    figures = {CHANGES: changes_figure(result), SPREAD: spread_figure(result)}
    pictures = {
        name: output.figure(name, figure).read_bytes()
        for name, figure in figures.items()
        if figure is not None
    }
    output.add(write_table(result, out / RESULT_TABLE))
    provenance = collect_provenance(typed_command.get())
    with whole_file(out / PAGE) as made:
        page = fleet_page(result, pictures, provenance, str(folder))
        made.write_text(page, encoding="utf-8")
    output.add(out / PAGE)
    numbers = result.result() | {"provenance": provenance.result()}
    output.result(numbers)
    for rig in result.with_findings:
        console.print(f"  {rig.sentence(result.units)}")
    output.close(" ".join(filter(None, [result.sentence, result.warning, f"Page: {out / PAGE}"])))
    failed = result.of("failed")
    if len(failed) == len(result.rigs):
        raise TendonError(f"no rig could be fitted; {failed[0].name}: {failed[0].error}")
    return numbers
