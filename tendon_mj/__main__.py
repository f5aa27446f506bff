"""`tendon-mj`, which is also `python -m tendon_mj`."""

import signal
import sys


def main() -> int:
    """Run the command line; returns its exit status, 130 also for a Ctrl-C while it loads."""
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _interrupt_once)
    try:
        from tendon_mj.cli.main import main as run
    except KeyboardInterrupt:
        print("tendon-mj: interrupted; nothing was begun", file=sys.stderr)
        return 130
    return run()


def _interrupt_once(number: int, frame: object) -> None:
    """Interrupt the command, and let it end: a second Ctrl-C would cut off its way out."""
    signal.signal(number, signal.SIG_IGN)
    raise KeyboardInterrupt


if __name__ == "__main__":
    sys.exit(main())
