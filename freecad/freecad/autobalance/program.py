"""The ``autobalance`` command: where it is, and a run of it with progress, cancel and its own error lines."""

import json
import os
import queue
import shutil
import subprocess
import sys
import threading
import time

import FreeCAD

PREFERENCES = "User parameter:BaseApp/Preferences/Mod/autobalance"
MISSING = (
    "autobalance was not found; expected its command in PATH or in the preference 'Command'; "
    "install it with: pip install autobalance[step], or from a macro: "
    "from freecad.autobalance import program; program.make_environment()"
)


def complain(error, label=""):
    """Print an error's own lines in the report view; return them as one text."""
    lines = [line for line in str(error).splitlines() if line] or [type(error).__name__]
    for line in lines:
        FreeCAD.Console.PrintError("autobalance: %s%s\n" % (label and label + ": ", line))
    return "\n".join(lines)


def warn(text):
    """Print a warning in the report view."""
    FreeCAD.Console.PrintWarning("autobalance: %s\n" % text)


QUIET = ("grade",)
"""Commands that have no progress; their error is a line of text."""


class CommandError(RuntimeError):
    """The command refused or was cancelled; its own line."""


class NotFoundError(CommandError):
    """There is no command."""


def command():
    """Return the command as a list of words.

    Raises
    ------
    CommandError
        If there is none.
    """
    chosen = FreeCAD.ParamGet(PREFERENCES).GetString("Command", "")
    found = chosen or os.environ.get("AUTOBALANCE_COMMAND") or shutil.which("autobalance") or own_command()
    if not found or not os.path.isfile(found):
        raise NotFoundError(MISSING if not found else "autobalance is not at %s; %s" % (found, MISSING))
    return [found]


def own_command():
    """Return the command of the environment that ``make_environment`` has made; None without."""
    folder = os.path.join(FreeCAD.getUserAppDataDir(), "autobalance-venv")
    name = os.path.join("Scripts", "autobalance.exe") if sys.platform == "win32" else "bin/autobalance"
    path = os.path.join(folder, name)
    return path if os.path.isfile(path) else None


def make_environment(source="autobalance[step]"):
    """Make a virtual environment of its own and install the command into it."""
    folder = os.path.join(FreeCAD.getUserAppDataDir(), "autobalance-venv")
    python = shutil.which("python3") or shutil.which("python")
    if python is None:
        raise CommandError("no python3 was found to make an environment with; install Python 3.11 or newer")
    inside = os.path.join(folder, "Scripts" if sys.platform == "win32" else "bin", "python")
    for words in ([python, "-m", "venv", folder], [inside, "-m", "pip", "install", source]):
        done = subprocess.run(words, capture_output=True, text=True, check=False)
        if done.returncode:
            raise CommandError("cannot install autobalance: " + done.stderr.strip().splitlines()[-1])
    return own_command()


def answer(words, folder):
    """Return the report of a command that writes one with ``--json``."""
    path = os.path.join(folder, "answer.json")
    run([*words, "--json", path], folder)
    with open(path, encoding="utf-8") as stream:
        return json.load(stream)


def run(words, folder, tell=None, cancelled=None):
    """Run the command in a folder; return its exit code, 0 or 4. Its warnings go to the report view.

    Parameters
    ----------
    words : list of str
    tell : callable or None
        Told stage and share.
    cancelled : callable or None
        Asked ten times a second; True ends the command.

    Raises
    ------
    CommandError
        If it fails or is cancelled: its own line.
    """
    environment = {k: v for k, v in os.environ.items() if k not in ("PYTHONPATH", "PYTHONHOME")}
    process = subprocess.Popen(
        [*command(), *words, *([] if words[0] in QUIET else ["--progress", "json"])],
        cwd=folder,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        env=environment,
    )
    lines = queue.Queue()
    reader = threading.Thread(target=_read, args=(process.stderr, lines), daemon=True)
    reader.start()
    warnings, error = [], None
    while process.poll() is None or reader.is_alive() or not lines.empty():
        if cancelled is not None and cancelled():
            end(process)
            raise CommandError("cancelled; nothing was changed")
        try:
            line = lines.get(timeout=0.1)
        except queue.Empty:
            continue
        told = _object(line)
        if "error" in told:
            error = str(told["error"])
        elif "warning" in told:
            warnings.append(str(told["warning"]))
        elif tell is not None and "stage" in told:
            tell(str(told["stage"]), float(told["share"]))
    if error is not None or process.returncode not in (0, 4):
        last = warnings[-1] if warnings else "no word"
        if words[0] in QUIET and warnings:
            error = last.partition("error: ")[2] or last
        raise CommandError(error or "autobalance ended with exit code %d: %s" % (process.returncode, last))
    for each in warnings:
        warn(each)
    return process.returncode


def end(process):
    """End a command: it ends by itself within two seconds, else it is killed."""
    process.terminate()
    until = time.monotonic() + 3.0
    while process.poll() is None and time.monotonic() < until:
        time.sleep(0.05)
    if process.poll() is None:
        process.kill()
    process.wait()


def _read(stream, lines):
    for line in stream:
        lines.put(line.decode("utf-8", "replace").strip())


def _object(line):
    try:
        found = json.loads(line)
    except ValueError:
        return {"warning": line} if line else {}
    return found if isinstance(found, dict) else {}
