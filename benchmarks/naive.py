"""The way one would script it: trimesh, its mass properties, and its boolean inside a root finder."""

import sys
from pathlib import Path

import trimesh
from scipy.optimize import brentq

RHO = 7.85e-3
BOB_G_MM = (248.69 + 0.28 * 261.5) * 26.9
PERMISSIBLE_G_MM = 10.6864


def main() -> None:
    crank = trimesh.load(sys.argv[1])
    z_top = 8.0 + 15.3319494 + 4.44237129

    def cut(depth: float) -> trimesh.Trimesh:
        boxes = []
        for sign in (-1.0, 1.0):
            box = trimesh.creation.box((120.0, 60.0, depth + 1.0))
            box.apply_translation((0.0, -30.0 - 14.1, sign * (z_top + 0.5 - depth / 2.0)))
            boxes.append(box)
        return trimesh.boolean.difference([crank, *boxes], engine="manifold", check_volume=False)

    def residual(depth: float) -> float:
        properties = cut(depth).mass_properties
        value = RHO * properties.volume * properties.center_mass[1] + BOB_G_MM
        return 0.0 if abs(value) <= 0.01 * PERMISSIBLE_G_MM else float(value)

    depth = float(brentq(residual, 0.1, 4.4))
    cut(depth).export(str(Path(sys.argv[1]).with_name("naive.stl")))
    print(f"depth {depth:.4f} mm, residual {residual(depth):.3f} g·mm")


if __name__ == "__main__":
    main()
