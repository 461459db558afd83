"""Milled pockets: outline and trace."""
