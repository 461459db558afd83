"""``sheet.pdf`` and DXF: what the machinist needs at the machine, on pages that flow."""
