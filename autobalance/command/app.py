"""``autobalance app``: the whole program in a browser on this machine."""

from __future__ import annotations

import argparse

DEFAULT_PROJECT = "autobalance-project"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describe the command line."""
    parser.epilog = (
        "examples:\n"
        "  autobalance app                      an empty project in ./autobalance-project\n"
        "  autobalance app crank.stl            the same with a crank copied in\n"
        "  autobalance app job.toml --no-browser --port 8123"
    )
    parser.add_argument(
        "source", nargs="?", metavar="CRANK|JOB|REPORT|FOLDER", help="copied into the project first"
    )
    parser.add_argument("--port", type=int, default=0, metavar="N", help="port on 127.0.0.1 (any)")
    parser.add_argument("--no-browser", action="store_true", help="print the address, open nothing")
    parser.add_argument(
        "--project", default=DEFAULT_PROJECT, metavar="DIR", help=f"its folder ({DEFAULT_PROJECT})"
    )
    parser.add_argument("--max-upload-mb", type=int, default=512, metavar="N", help="largest upload (512)")
    parser.add_argument("--memory-mb", type=int, default=4096, metavar="N", help="memory of one run (4096)")


def run(arguments: argparse.Namespace) -> int:
    """Serve until interrupted; 0."""
    from autobalance.command.console import say
    from autobalance.web_app.serving import app

    app(
        arguments.source,
        port=arguments.port,
        browser=not arguments.no_browser,
        project=arguments.project,
        max_upload_mb=arguments.max_upload_mb,
        memory_mb=arguments.memory_mb,
        told=lambda address: say(f"autobalance app: {address}"),
    )
    return 0
