"""What the command knows of factors and grades, for the panel: lists and the curve of factors."""

import shutil
import tempfile

from freecad.autobalance import program
from freecad.autobalance.crank import job_words
from PySide import QtCore, QtGui

WIDTH, HEIGHT, EDGE = 230, 130, 20
CURVES = (("greatest_n", "#b3400f"), ("greatest_inline_n", "#1f5fa8"), ("greatest_transverse_n", "#5a7d1a"))


def _answer(work):
    folder = tempfile.mkdtemp(prefix="autobalance-")
    try:
        return program.answer(work(folder), folder)
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def grades():
    """Return the list of grades, each with the crank drive that it is for; none without the command."""
    try:
        listed = _answer(lambda _: ["grade"])["grades"]
    except program.CommandError:  # reported where the crank is balanced
        return []
    return ["%g – %s" % (each["grade_mm_s"], each["what"]) for each in listed]


def factors_of(crank):
    """Return what each balance factor does: ``factors`` of the report of ``forces``.

    Raises
    ------
    CommandError
        If no rod length is stated, or the command refuses.
    """
    if not crank.RodLength > 0.0 and not crank.JobFile:
        raise program.CommandError("the rod length is 0; expected the rod length in mm")
    return _answer(lambda folder: ["forces", *job_words(crank, folder)])["factors"]


def curve_picture(factors, factor):
    """Return greatest force, in line and across, over the factor, as a picture; the crank's own is marked."""
    rows = factors["rows"]
    most = max(row[key] for row in rows for key, _ in CURVES) or 1.0

    def at(x, force):
        return QtCore.QPointF(
            EDGE + (WIDTH - 2 * EDGE) * x, HEIGHT - EDGE - (HEIGHT - 2 * EDGE) * force / most
        )

    picture = QtGui.QPixmap(WIDTH, HEIGHT)
    picture.fill(QtCore.Qt.white)
    painter = QtGui.QPainter(picture)
    painter.setRenderHint(QtGui.QPainter.Antialiasing)
    painter.setPen(QtGui.QPen(QtGui.QColor("#888888"), 1))
    painter.drawLine(at(0.0, 0.0), at(1.0, 0.0))
    painter.drawLine(at(factor, 0.0), at(factor, most))
    painter.drawText(QtCore.QPointF(EDGE - 4, HEIGHT - 8), "0")
    painter.drawText(QtCore.QPointF(WIDTH - EDGE - 4, HEIGHT - 8), "1")
    painter.drawText(QtCore.QPointF(4, 14), "%.0f N" % most)
    for place, (key, colour) in enumerate(CURVES):
        painter.setPen(QtGui.QPen(QtGui.QColor(colour), 2))
        points = [at(row["factor"], row[key]) for row in rows]
        for k in range(1, len(points)):
            painter.drawLine(points[k - 1], points[k])
        painter.drawText(QtCore.QPointF(62 + 56 * place, 14), ("total", "in line", "across")[place])
    painter.end()
    return picture
