"""One file per subcommand: arguments, printing, exit codes."""

from autobalance.command.main import main

__all__ = ["main"]
