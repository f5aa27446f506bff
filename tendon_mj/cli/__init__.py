"""The command line: `tendon-mj COMMAND --out DIR`."""

from tendon_mj.cli.interruption import interruptible as interruptible
from tendon_mj.cli.main import main as main
from tendon_mj.cli.output import Output as Output
from tendon_mj.cli.output import console as console
from tendon_mj.cli.output import progress_bar as progress_bar
