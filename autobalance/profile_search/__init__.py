"""Counterweight profiles as splines: searched for the best that meet the balance exactly."""
