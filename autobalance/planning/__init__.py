"""How deep and which cuts: pure numbers on the effects of cuts."""
