"""Crank, rods and pistons as masses that move: kinematics, parts, balance factor, forces."""
