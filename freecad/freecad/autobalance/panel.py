"""The task panel: weights with their sums, factor, grade, kind; run, cancel, and the list of cuts."""

import json

import FreeCADGui
from freecad.autobalance import program
from freecad.autobalance.advisor import curve_picture, factors_of, grades
from freecad.autobalance.crank import METHODS, PLANS, balanceable, size_of
from freecad.autobalance.cuts import residual_of
from freecad.autobalance.translation import translate
from PySide import QtCore, QtGui

LISTS = (
    ("Rotating", "Rotating weights [g]"),
    ("Reciprocating", "Reciprocating weights [g]"),
    ("Crankpin", "Crankpin [g]"),
    ("Drills", "Drills at hand [mm]"),
)
NUMBERS = (
    ("Density", "Density [kg/m³]"),
    ("RodLength", "Rod length [mm], 0: none"),
    ("Factor", "Balance factor"),
    ("Grade", "Grade G"),
    ("SpeedRpm", "Speed [1/min]"),
)


def show(crank):
    """Open the panel on a balanced crank."""
    panel = Panel(crank)
    FreeCADGui.Control.showDialog(panel)
    return panel


class Panel:
    """What FreeCAD shows in the task view."""

    def __init__(self, crank):
        self.crank, self.stopped = crank, False
        self.form = QtGui.QWidget()
        self.form.setWindowTitle(translate("Balanced crank"))
        layout = QtGui.QFormLayout(self.form)
        self.fields = {}
        self.choose_body(layout)
        for name, words in LISTS:
            field = QtGui.QLineEdit("; ".join("%g" % value for value in getattr(crank, name)))
            field.textChanged.connect(self.sums)
            self.fields[name] = field
            layout.addRow(translate(words), field)
        for name, words in NUMBERS:
            self.fields[name] = self.grade_field() if name == "Grade" else QtGui.QLineEdit()
            self.fields[name].setText("%g" % getattr(crank, name))
            self.fields[name].textChanged.connect(self.sums)
            layout.addRow(translate(words), self.fields[name])
        self.advise = QtGui.QPushButton(translate("Factor: what each does"))
        self.advise.clicked.connect(self.curve)
        self.advice, self.picture = QtGui.QLabel(), QtGui.QLabel()
        self.advice.setWordWrap(True)
        layout.addRow(self.advise, self.advice)
        layout.addRow(self.picture)
        for name, values, words in (("Method", METHODS, "Kind of cut"), ("Plan", PLANS, "Plan")):
            box = QtGui.QComboBox()
            box.addItems(list(values))
            box.setCurrentIndex(list(values).index(getattr(crank, name)))
            self.fields[name] = box
            layout.addRow(translate(words), box)
        self.limits = QtGui.QPlainTextEdit("\n".join(crank.Limits))
        self.limits.setMaximumHeight(60)
        layout.addRow(translate("Limits, key=value"), self.limits)
        self.bob = QtGui.QLabel()
        layout.addRow(translate("Bob-weight"), self.bob)
        self.bar = QtGui.QProgressBar()
        layout.addRow(self.bar)
        layout.addRow(self.buttons())
        self.said = QtGui.QLabel()
        self.said.setWordWrap(True)
        layout.addRow(self.said)
        self.cuts = QtGui.QTreeWidget()
        self.cuts.setHeaderLabels(["cut", "depth [mm]", "takes [g]"])
        self.cuts.itemSelectionChanged.connect(self.light)
        layout.addRow(self.cuts)
        self.fields["Density"].textChanged.connect(self.measure)
        self.measure()
        self.sums()
        self.result()

    def choose_body(self, layout):
        """Add the choice of a body, and its size."""
        self.body, self.size = QtGui.QComboBox(), QtGui.QLabel()
        self.size.setWordWrap(True)
        self.bodies = balanceable(self.crank)
        self.body.addItems([each.Label for each in self.bodies])
        self.body.currentIndexChanged.connect(self.measure)
        layout.addRow(translate("Body"), self.body)
        layout.addRow(translate("Size: is the unit right?"), self.size)

    def buttons(self):
        """Return the row of buttons."""
        row = QtGui.QHBoxLayout()
        self.go, self.cancel = QtGui.QPushButton(translate("Balance")), QtGui.QPushButton(translate("Cancel"))
        self.go.clicked.connect(self.run)
        self.cancel.clicked.connect(self.stop)
        row.addWidget(self.go)
        row.addWidget(self.cancel)
        return row

    def measure(self, _=None):
        """Show size and mass of the body, by which a wrong unit is seen."""
        try:
            self.size.setText(size_of(self.bodies[self.body.currentIndex()], self.values("Density")[0]))
        except (ValueError, IndexError):
            self.size.setText("–")

    def grade_field(self):
        """Return a field whose completer lists the grades, each with the drive that it is for."""
        field = QtGui.QLineEdit()
        self.grades = QtGui.QCompleter(grades())
        self.grades.setFilterMode(QtCore.Qt.MatchContains)
        self.grades.setMaxVisibleItems(12)
        field.setCompleter(self.grades)
        return field

    def curve(self):
        """Draw what each balance factor does, and name the best."""
        if not self.take():
            return
        try:
            factors = factors_of(self.crank)
        except Exception as error:  # shown to the one who pressed the button
            self.advice.setText(str(error))
            return
        self.advice.setText(
            translate("smallest first order %.3f, smallest maximum force %.3f")
            % (factors["least_first_order"], factors["least_greatest"])
        )
        self.picture.setPixmap(curve_picture(factors, self.crank.Factor))

    def values(self, name):
        """Return the numbers of a field, as people type them."""
        text = self.fields[name].text().replace(",", ".").partition(" – ")[0]
        return [float(each) for each in text.replace(";", " ").split()]

    def sums(self):
        """Show the bob-weight: rotating, and its share of the reciprocating."""
        try:
            factor = self.values("Factor")[0]
            total = sum(self.values("Rotating")) + sum(self.values("Crankpin"))
            self.bob.setText("%.2f g" % (total + factor * sum(self.values("Reciprocating"))))
        except (ValueError, IndexError):
            self.bob.setText("–")

    def run(self):
        """Set the properties and balance."""
        crank, self.stopped = self.crank, False
        if not self.take():
            return
        crank.Proxy.tell, crank.Proxy.cancelled = self.tell, self.asked
        crank.touch()
        try:
            crank.Proxy.balance(crank)
            crank.Document.recompute()
            self.result()
        except Exception as error:  # shown to the one who pressed the button
            self.said.setText(program.complain(error))
            crank.purgeTouched()  # else the document's next recompute fails once more
        finally:
            crank.Proxy.tell = crank.Proxy.cancelled = None

    def take(self):
        """Set the crank's properties to what the fields hold; return whether they are numbers."""
        crank = self.crank
        try:
            for name, _ in LISTS:
                setattr(crank, name, self.values(name))
            for name, _ in NUMBERS:
                setattr(crank, name, self.values(name)[0])
        except (ValueError, IndexError):
            self.said.setText(translate("a weight or number is none; expected numbers with ; between them"))
            return False
        chosen = self.bodies[self.body.currentIndex()]
        if chosen is not crank.Source:
            crank.Source = chosen
        for name in ("Method", "Plan"):
            setattr(crank, name, self.fields[name].currentText())
        crank.Limits = [line for line in self.limits.toPlainText().splitlines() if line.strip()]
        return True

    def tell(self, words, share):
        """Show how far it is."""
        self.bar.setValue(round(100 * share))
        self.bar.setFormat("%s %%p %%" % words)

    def asked(self):
        """Let the window live while the command works; return whether it was cancelled."""
        QtCore.QCoreApplication.processEvents()
        return self.stopped

    def stop(self):
        """Cancel."""
        self.stopped = True

    def result(self):
        """List the cuts, and say what is left."""
        crank = self.crank
        self.cuts.clear()
        if not crank.Report:
            return
        self.said.setText(
            "%s: residual %.2f of %.2f g mm permitted. %s"
            % (crank.Outcome.replace("_", " "), crank.Residual, crank.Permissible, crank.Reason)
        )
        tree = residual_of(crank)
        if tree is not None:
            words = translate("FreeCAD's own residual of the tree of cuts: %.2f g mm")
            self.said.setText(self.said.text() + " " + words % tree.ByFreeCAD)
        for cut in json.loads(crank.Report)["corrections"]:
            row = QtGui.QTreeWidgetItem(
                [cut["label"], "%.3f" % cut["depth_mm"], "%.2f" % cut["removed_mass_g"]]
            )
            self.cuts.addTopLevelItem(row)
        self.cuts.resizeColumnToContents(0)

    def light(self):
        """Light up the cut of the selected row, where its native feature is there."""
        FreeCADGui.Selection.clearSelection()
        for row in self.cuts.selectedItems():
            for found in self.crank.Document.getObjectsByLabel(row.text(0)):
                FreeCADGui.Selection.addSelection(found)

    def getStandardButtons(self):
        """Show Close alone."""
        close = QtGui.QDialogButtonBox.Close
        return getattr(close, "value", None) or int(close)  # Qt 6 has enumerations of Python, Qt 5 numbers
