"""A FreeCAD workbench: a crank that the ``autobalance`` command balances whenever its weights change."""
