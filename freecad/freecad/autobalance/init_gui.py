"""What FreeCAD's window loads: the workbench with its commands."""

import os

import FreeCAD
import FreeCADGui


class AutobalanceWorkbench(FreeCADGui.Workbench):
    """Menu and toolbar."""

    MenuText = "autobalance"
    ToolTip = "Balance crankshafts"

    def __init__(self):
        from freecad.autobalance import __file__ as here

        folder = os.path.dirname(here)
        self.__class__.Icon = os.path.join(folder, "icons", "autobalance.svg")
        if hasattr(FreeCADGui, "addLanguagePath"):
            FreeCADGui.addLanguagePath(os.path.join(folder, "translations"))

    def Initialize(self):
        """Enter the commands."""
        from freecad.autobalance.commands import COMMANDS

        for name, command in COMMANDS.items():
            FreeCADGui.addCommand(name, command)
        self.appendToolbar("autobalance", list(COMMANDS))
        self.appendMenu("autobalance", list(COMMANDS))

    def GetClassName(self):
        """Say that it is written in Python."""
        return "Gui::PythonWorkbench"


FreeCADGui.addWorkbench(AutobalanceWorkbench())
FreeCAD.Console.PrintLog("autobalance: workbench loaded\n")
