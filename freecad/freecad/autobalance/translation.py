"""Words of the window in the user's language: ``translations/autobalance_*.qm``, made of the ``.ts``."""

import FreeCAD

CONTEXT = "autobalance"


def translate(words):
    """Return words in the language of the window; English where there is none."""
    if not hasattr(FreeCAD, "Qt"):
        return words
    return FreeCAD.Qt.translate(CONTEXT, words)
