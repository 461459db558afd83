"""The documented formulas of crankshaft balancing, each with its source and its misprints.

Plain numbers in, with the unit at the end of each name; numbers or small records out. ``autobalance calc``
calls any of them. Those that only the room's own modules define convert degrees, revolutions a minute or
millimetres for a formula of another room; all others are that room's own function.
"""

from autobalance.engines.forces.counterweight import (
    bolted_pair,
    complete_balance,
    fan_counterweight,
    fan_counterweight_for,
)
from autobalance.engines.forces.stroking import (
    crankpin_overlap_mm,
    disc_rotor,
    stroke_for_displacement_mm,
    stroked_crank,
    substitute_rotor,
)
from autobalance.materials import density
from autobalance.running_gear.conrod import (
    balancing_counterweights,
    conrod_cut_in_two,
    cylinder_mass_g,
    final_hole_depth_mm,
    section_sums,
)
from autobalance.running_gear.loads import order_table
from autobalance.running_gear.parts import (
    bob_weight_g,
    correction_mass_g,
    counterweight_product_g_mm,
    sum_of_parts,
)
from autobalance.running_gear.shafts import counter_rotating_shaft_g_mm, second_order_pair, shaft_pair
from autobalance.running_gear.slider_crank import harmonic_coefficient, harmonic_series, swept_volume_cm3
from autobalance.theory.bearings import (
    dry_friction,
    friction_coefficient,
    journal_friction_n_m,
    mean_bearing_loads,
    oil_viscosity_mm2_s,
    rolling_friction_n_m,
    short_bearing,
    squeeze_film,
)
from autobalance.theory.kinematics import dead_centres, greatest_piston_speed, piston_harmonics, piston_motion
from autobalance.theory.machines import index_test, machine_accuracy, repeated_readings
from autobalance.theory.tolerance import (
    achieved_grade,
    convert_unbalance,
    permissible_unbalance,
    plane_shares,
    unbalance_in_planes,
)
from autobalance.theory.weights import (
    balance_factor,
    centrifugal_force_n,
    conrod,
    conrod_on_scales,
    drill_chart,
    drilled_hole,
    first_order_force,
    shaft_roll_moment_n_m,
)

__all__ = [
    "achieved_grade",
    "balance_factor",
    "balancing_counterweights",
    "bob_weight_g",
    "bolted_pair",
    "centrifugal_force_n",
    "complete_balance",
    "conrod",
    "conrod_cut_in_two",
    "conrod_on_scales",
    "convert_unbalance",
    "correction_mass_g",
    "counter_rotating_shaft_g_mm",
    "counterweight_product_g_mm",
    "crankpin_overlap_mm",
    "cylinder_mass_g",
    "dead_centres",
    "density",
    "disc_rotor",
    "drill_chart",
    "drilled_hole",
    "dry_friction",
    "fan_counterweight",
    "fan_counterweight_for",
    "final_hole_depth_mm",
    "first_order_force",
    "friction_coefficient",
    "greatest_piston_speed",
    "harmonic_coefficient",
    "harmonic_series",
    "index_test",
    "journal_friction_n_m",
    "machine_accuracy",
    "mean_bearing_loads",
    "oil_viscosity_mm2_s",
    "order_table",
    "permissible_unbalance",
    "piston_harmonics",
    "piston_motion",
    "plane_shares",
    "repeated_readings",
    "rolling_friction_n_m",
    "second_order_pair",
    "section_sums",
    "shaft_pair",
    "shaft_roll_moment_n_m",
    "short_bearing",
    "squeeze_film",
    "stroke_for_displacement_mm",
    "stroked_crank",
    "substitute_rotor",
    "sum_of_parts",
    "swept_volume_cm3",
    "unbalance_in_planes",
]
