"""The command line: `tendon-mj COMMAND --out DIR`; a module has one command or those of a topic."""

from tendon_mj.cli.commands import COMMANDS as COMMANDS
from tendon_mj.cli.commands import load_command as load_command
from tendon_mj.cli.commands import main as main
from tendon_mj.cli.output import Output as Output
from tendon_mj.cli.output import console as console
from tendon_mj.cli.output import progress_bar as progress_bar
