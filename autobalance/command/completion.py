"""``autobalance completion bash|zsh|fish``: a script that completes commands and options."""

from __future__ import annotations

import argparse

SHELLS = ("bash", "zsh", "fish")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.epilog = (
        "examples:\n"
        '  eval "$(autobalance completion bash)"                        in ~/.bashrc\n'
        "  autobalance completion fish > ~/.config/fish/completions/autobalance.fish"
    )
    parser.add_argument("shell", choices=SHELLS, help="shell that the script is for")


def run(arguments: argparse.Namespace) -> int:
    """Print the script."""
    import shtab

    from autobalance.command.console import say_as_it_is
    from autobalance.command.main import full_parser

    say_as_it_is(shtab.complete(full_parser(), shell=arguments.shell))
    return 0
