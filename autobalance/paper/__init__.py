"""``sheet.pdf`` and DXF: pages for the machinist at the machine."""
