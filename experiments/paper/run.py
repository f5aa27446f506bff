"""Reproduces the paper's figures: pictures, ``numbers.md`` and ``result.json`` in one folder.

Usage: python experiments/paper/run.py [FOLDER] [RANDOM_HISTORIES]
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

from tendon_mj.errors import TendonError
from tendon_mj.view.paper import run_paper


def report(what: str, done: int, total: int) -> None:
    """Say how far it is."""
    print(f"\r{what}: {done}/{total}".ljust(60), end="" if done < total else "\n", flush=True)


def main() -> None:
    """Write everything into the folder given."""
    out = Path(sys.argv[1] if len(sys.argv) > 1 else "out/paper")
    histories = int(sys.argv[2]) if len(sys.argv) > 2 else 100
    try:
        result = run_paper(out, report, histories)
    except TendonError as error:
        sys.exit(f"error: {error}")
    text = json.dumps(result, indent=2, allow_nan=False) + "\n"
    (out / "result.json").write_text(text, encoding="utf-8")
    print(
        f"T_out within {result['agreement']['max_difference_of_range']:.2%} of range on all routes"
    )
    print(f"Fig. 4 (a): slopes within {result['figure_4a']['slope_error']:.2%} of K_ap")
    print(f"wrote {out}")


if __name__ == "__main__":
    main()
