"""`tendon-mj`, which is also `python -m tendon_mj`."""

import sys


def main() -> int:
    """Run the command line; returns its exit status."""
    try:
        from tendon_mj.cli import main as run
    except KeyboardInterrupt:  # while the packages load
        print("tendon-mj: interrupted", file=sys.stderr)
        return 130
    except ModuleNotFoundError as error:
        from tendon_mj.errors import MissingPackageError

        print(f"tendon-mj: {MissingPackageError.of_lab('the command', error)}", file=sys.stderr)
        return 2
    return run()


if __name__ == "__main__":
    sys.exit(main())
