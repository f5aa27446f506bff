"""`tendon-mj`, which is also `python -m tendon_mj`."""

import sys

from tendon_mj.cli import interruptible


def main() -> int:
    """Run the command line; returns its exit status, 130 also for a Ctrl-C while it loads."""
    with interruptible():
        try:
            from tendon_mj.cli import main as run
        except KeyboardInterrupt:
            print("tendon-mj: interrupted; nothing was begun", file=sys.stderr)
            return 130
        return run()


if __name__ == "__main__":
    sys.exit(main())
