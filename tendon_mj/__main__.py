"""`python -m tendon_mj` is `tendon-mj`."""

import sys

from tendon_mj.cli.main import main

if __name__ == "__main__":
    sys.exit(main())
