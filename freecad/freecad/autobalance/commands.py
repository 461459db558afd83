"""Commands of the workbench; what they do is done by functions that a macro may call, too."""

import json
import os
import shutil
import subprocess
import tempfile

import FreeCAD
from freecad.autobalance import program
from freecad.autobalance.crank import (
    check_source,
    input_hash,
    job_words,
    make_crank,
    shape_of,
    write_job,
    write_source,
)
from freecad.autobalance.cuts import make_cuts
from freecad.autobalance.datums import recognised
from freecad.autobalance.translation import translate

PRESETS = (
    "single",
    "pressed-up-single",
    "pressed-up-single-no-pin",
    "v-twin-45",
    "parallel-twin-360",
    "inline-3",
    "inline-4",
    "inline-6",
    "v6-60",
    "v8-crossplane",
    "v8-flatplane",
    "v12-60",
)
"""Of ``autobalance generate``."""
ICONS = os.path.join(os.path.dirname(__file__), "icons")


def new_crank(preset="single", document=None):
    """Return a crank that ``autobalance generate`` builds, as a solid of the document."""
    import Part

    document = document or FreeCAD.ActiveDocument or FreeCAD.newDocument()
    folder = tempfile.mkdtemp(prefix="autobalance-")
    try:
        path = os.path.join(folder, "crank.step")
        program.run(["generate", preset, "-o", path], folder)
        made = document.addObject("Part::Feature", "Crank")
        made.Shape = Part.read(path).Solids[0]
        return made
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def inspect(source):
    """Return a group of what is recognised on a crank: axis, main journals, crankpins, webs, faces."""
    check_source(source)
    folder = tempfile.mkdtemp(prefix="autobalance-")
    try:
        file = write_source(source, folder)
        unit = ["--unit", "mm"] if file.endswith(".stl") else []
        program.run(["inspect", file, *unit, "--json", "found.json"], folder)
        with open(os.path.join(folder, "found.json"), encoding="utf-8") as stream:
            found = json.load(stream)
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    return recognised(source, found)


def verify(crank):
    """Return the lines of ``autobalance verify`` on a crank's report, made again in a temporary folder."""
    folder = tempfile.mkdtemp(prefix="autobalance-")
    try:
        out = os.path.join(folder, "out")
        program.run(["balance", *job_words(crank, folder), "-o", out, "--only", "json"], folder)
        program.run(["verify", os.path.join(out, "report.json")], folder)
        return "every claim of the report holds"
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def sheet(crank, target):
    """Write the shop sheet of a balanced crank to a file."""
    folder = tempfile.mkdtemp(prefix="autobalance-")
    try:
        out = os.path.join(folder, "out")
        program.run(["balance", *job_words(crank, folder), "-o", out, "--only", "pdf"], folder)
        shutil.copy(os.path.join(folder, "out", "sheet.pdf"), target)
        return target
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def selected():
    """Return the one selected object.

    Raises
    ------
    CommandError
        If it is not one.
    """
    import FreeCADGui

    found = FreeCADGui.Selection.getSelection()
    if len(found) != 1:
        raise program.CommandError("%d objects are selected; select the body of one crank" % len(found))
    return found[0]


def offer_environment():
    """Ask whether to make an environment for the command, and make it; the last word is a line."""
    from PySide import QtGui

    words = translate("autobalance was not found. Make a virtual environment and install it there?")
    if QtGui.QMessageBox.question(None, "autobalance", words) != QtGui.QMessageBox.Yes:
        return
    try:
        FreeCAD.Console.PrintMessage("autobalance: installed as %s\n" % program.make_environment())
    except program.CommandError as error:
        program.complain(error)


class Command:
    """A button: its words, its icon, and the function behind it."""

    def __init__(self, words, tip, icon, work):
        self.words, self.tip, self.icon, self.work = words, tip, icon, work

    def GetResources(self):
        """Return text, tip and icon."""
        return {
            "MenuText": translate(self.words),
            "ToolTip": translate(self.tip),
            "Pixmap": os.path.join(ICONS, self.icon),
        }

    def IsActive(self):
        """Return whether there is a document."""
        return FreeCAD.ActiveDocument is not None

    def Activated(self):
        """Do the work; what goes wrong is one line in the report view, and the document stays as it was."""
        document = FreeCAD.ActiveDocument
        document.openTransaction(self.words)
        try:
            self.work()
            document.commitTransaction()
        except program.NotFoundError as error:
            document.abortTransaction()
            program.complain(error)
            offer_environment()
        except Exception as error:  # a command of a window: nobody is above it
            document.abortTransaction()
            program.complain(error)


def _balance():
    from freecad.autobalance.panel import show

    chosen = selected()
    if hasattr(chosen, "InputHash"):
        show(chosen)
        return
    show(make_crank(chosen))


def _write_job():
    from PySide import QtGui

    folder = QtGui.QFileDialog.getExistingDirectory(None, "Write job")
    if folder:
        write_job(selected(), folder)


def _sheet():
    from PySide import QtCore, QtGui

    path = sheet(selected(), os.path.join(tempfile.mkdtemp(prefix="autobalance-"), "sheet.pdf"))
    QtGui.QDesktopServices.openUrl(QtCore.QUrl.fromLocalFile(path))


def _new():
    from PySide import QtGui

    words = translate("Preset of the crank")
    preset, chosen = QtGui.QInputDialog.getItem(None, "autobalance", words, list(PRESETS), 0, True)
    if chosen:
        new_crank(preset)


def _verify():
    FreeCAD.Console.PrintMessage("autobalance: %s\n" % verify(selected()))


def open_app():
    """Start the app, which opens in a browser."""
    return subprocess.Popen([*program.command(), "app"])


COMMANDS = {
    "Autobalance_New": Command("New crank", "A crank of the generator's presets", "autobalance.svg", _new),
    "Autobalance_Inspect": Command(
        "Inspect",
        "Axis, journals, crankpins, webs and faces as a group",
        "verify.svg",
        lambda: inspect(selected()),
    ),
    "Autobalance_Balance": Command("Balance", "Balance the selected body", "autobalance.svg", _balance),
    "Autobalance_Cuts": Command(
        "Cuts", "The cuts as native features", "cuts.svg", lambda: make_cuts(selected())
    ),
    "Autobalance_Verify": Command("Verify", "Check every claim of the report", "verify.svg", _verify),
    "Autobalance_Sheet": Command("Sheet", "Open the shop sheet", "verify.svg", _sheet),
    "Autobalance_Job": Command("Write job", "Write job and solid to a folder", "cuts.svg", _write_job),
    "Autobalance_App": Command("App", "Open the app in a browser", "autobalance.svg", open_app),
}
__all__ = ["COMMANDS", "input_hash", "inspect", "make_cuts", "new_crank", "shape_of", "sheet", "verify"]
