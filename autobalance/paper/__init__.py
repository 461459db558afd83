"""``sheet.pdf`` and DXF: pages for the machinist at the machine."""

from autobalance.report.reportlab_alone import load_reportlab

load_reportlab()
