"""The command line: `tendon-mj COMMAND --out DIR`."""

from tendon_mj.cli.main import main as main
