"""The crank that bends and twists under the loads of its cycle."""
