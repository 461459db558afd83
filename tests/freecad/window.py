"""The workbench in a window that nobody sees: the panel balances, the cuts are drawn, a picture is taken.

Run by ``make freecad`` under Xvfb; ends with 0 or 1.
"""

import os
import sys
import time
import traceback

import FreeCAD
import FreeCADGui
from PySide import QtCore, QtGui

ROOT, PICTURE = os.environ["AUTOBALANCE_ROOT"], os.environ["AUTOBALANCE_PICTURE"]
import freecad  # noqa: E402

freecad.__path__.append(os.path.join(ROOT, "freecad", "freecad"))


def main():
    from freecad.autobalance import commands, init_gui, panel
    from freecad.autobalance.crank import make_crank

    assert init_gui.AutobalanceWorkbench.MenuText == "autobalance"
    FreeCADGui.activateWorkbench("AutobalanceWorkbench")
    assert set(commands.COMMANDS) <= set(FreeCADGui.listCommands())
    document = FreeCAD.newDocument("window")
    source = commands.new_crank("single", document)
    obj = make_crank(source, document)
    shown = panel.show(obj)
    assert [shown.body.itemText(k) for k in range(shown.body.count())] == [source.Label]
    assert shown.size.text().endswith(" mm, 1857 g"), shown.size.text()
    shown.fields["Rotating"].setText("200; 100")
    shown.fields["Reciprocating"].setText("300")
    shown.fields["Factor"].setText("0.12")
    shown.fields["Grade"].setText("40 – crank drive")
    shown.fields["Method"].setCurrentIndex(panel.METHODS.index("drill"))
    shown.fields["Drills"].setText("10")
    grades = shown.grades.model()
    listed = [grades.data(grades.index(row, 0)) for row in range(grades.rowCount())]
    assert "40" in [each.partition(" – ")[0] for each in listed], listed
    shown.curve()
    assert "rod length" in shown.advice.text()
    shown.fields["RodLength"].setText("120")
    shown.curve()
    assert shown.advice.text().startswith("smallest first order 0.5"), shown.advice.text()
    assert not shown.picture.pixmap().isNull()
    assert shown.bob.text() == "336.00 g", shown.bob.text()
    shown.run()
    assert obj.Outcome == "within_tolerance", shown.said.text()
    assert shown.cuts.topLevelItemCount() == len(obj.Depths) > 0
    commands.make_cuts(obj)
    shown.result()
    assert "FreeCAD's own residual of the tree of cuts: " in shown.said.text(), shown.said.text()
    source.ViewObject.Visibility = False
    shown.cuts.topLevelItem(0).setSelected(True)
    assert len(FreeCADGui.Selection.getSelection()) == 1
    for each in document.Objects:
        each.ViewObject.Visibility = each is obj or each.Label.startswith("cut ")
    view = FreeCADGui.activeDocument().activeView()
    view.setCameraOrientation(
        FreeCAD.Rotation(FreeCAD.Vector(0, 0, 1), -125) * FreeCAD.Rotation(FreeCAD.Vector(1, 0, 0), 65)
    )
    for tool in [each for each in document.Objects if each.Label.startswith("cut ")]:
        tool.ViewObject.ShapeColor = (0.71, 0.25, 0.06)
    FreeCADGui.SendMsgToActiveView("ViewFit")
    for _ in range(20):
        QtCore.QCoreApplication.processEvents()
    picture(shown.form, view)
    before = list(obj.Depths)
    shown.fields["SpeedRpm"].setText("-1")
    shown.run()
    assert "speed_rpm" in shown.said.text(), shown.said.text()
    assert list(obj.Depths) == before
    check_buttons(document, source)
    check_dialogs(document)
    print("window: balanced in the panel, %d cuts" % len(before))


def picture(form, view):
    """Draw the whole panel, and the view beside it: a window is too low for the panel."""
    form.resize(440, form.sizeHint().height())
    panel = form.grab()
    beside = PICTURE.replace(".png", "-view.png")
    view.saveImage(beside, 900, panel.height(), "White")
    whole = QtGui.QPixmap(panel.width() + 900, panel.height())
    whole.fill(QtGui.QColor("white"))
    painter = QtGui.QPainter(whole)
    painter.drawPixmap(0, 0, panel)
    painter.drawPixmap(panel.width(), 0, QtGui.QPixmap(beside))
    painter.end()
    whole.save(PICTURE)


def check_buttons(document, source):
    """Each button that cannot work says so in one line of the report view, and changes nothing."""
    import Part
    from freecad.autobalance import commands, program

    two = document.addObject("Part::Feature", "Two")
    two.Shape = Part.makeCompound([Part.makeBox(1, 1, 1), Part.makeBox(1, 1, 1, FreeCAD.Vector(5, 0, 0))])
    sketch = document.addObject("Sketcher::SketchObject", "Sketch")
    document.recompute()
    said, asked, known = [], [], os.environ["AUTOBALANCE_COMMAND"]
    program.complain = lambda error, label="": said.append(str(error))
    commands.offer_environment = lambda: asked.append(True)
    cases = (
        ([], "0 objects are selected", known),
        ([source, two], "2 objects are selected", known),
        ([two], "2 solids", known),
        ([sketch], "is no solid", known),
        ([source], "not at /nowhere", "/nowhere/autobalance"),
    )
    before = sorted(each.Name for each in document.Objects)
    for chosen, why, place in cases:
        os.environ["AUTOBALANCE_COMMAND"] = place
        FreeCADGui.Selection.clearSelection()
        for each in chosen:
            FreeCADGui.Selection.addSelection(each)
        commands.COMMANDS["Autobalance_Inspect"].Activated()
        assert why in said[-1] and "\n" not in said[-1], said
        assert sorted(each.Name for each in document.Objects) == before
    os.environ["AUTOBALANCE_COMMAND"] = known
    assert (len(said), len(asked)) == (len(cases), 1)


def check_dialogs(document):
    """The button of a new crank asks for the preset, and does nothing when that is not chosen; the app begins."""
    from freecad.autobalance import commands

    before, asked = len(document.Objects), []
    for chosen, made in ((False, 0), (True, 1)):
        QtGui.QInputDialog.getItem = lambda *words, chosen=chosen: (
            asked.append(words) or (words[3][0], chosen)
        )
        commands.COMMANDS["Autobalance_New"].Activated()
        assert len(document.Objects) == before + made
    assert asked[0][3] == list(commands.PRESETS)
    os.environ["BROWSER"] = "true"
    app = commands.open_app()
    time.sleep(3.0)
    assert app.poll() is None, "the app ended at once"
    app.terminate()
    app.wait(20.0)


def guarded():
    code = 0
    try:
        main()
    except BaseException:
        traceback.print_exc(file=sys.stdout)
        code = 1
    sys.stdout.flush()
    os._exit(code)


QtCore.QTimer.singleShot(1500, guarded)
