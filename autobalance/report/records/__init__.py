"""Typed records of the reports, and the schemas made from them."""
