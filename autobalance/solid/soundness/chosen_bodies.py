"""Choice of the bodies of a file that are the crank."""

from __future__ import annotations

from autobalance.errors import BodiesError, SolidError
from autobalance.solid.csg.solid import Solid, union
from autobalance.solid.mesh.body_list import listed
from autobalance.solid.soundness.bodies import Body, are_apart, bodies_of
from autobalance.solid.soundness.repair import volume_change


def chosen_bodies(
    solid: Solid, body: int | str | None, pressed_up: bool, unite: bool
) -> tuple[Solid, int, list[str]]:
    """Return the chosen bodies of a solid as one, the number of its bodies, and the repairs.

    Parameters
    ----------
    body : int, str or None
        The body's number from 1, or ``all``; None for the only one or, if ``pressed_up``, for all of them.
    unite : bool
        Whether bodies that touch or overlap become one; else they stay as they are.

    Raises
    ------
    BodiesError
        If there are several and none was chosen.
    SolidError
        If there is no such body.
    """
    bodies, turned = bodies_of(solid)
    if len(bodies) == 1:
        if body not in (None, "all", 1):
            raise SolidError(f"body {body!r} does not exist; {_listed(bodies)}")
        return bodies[0].solid if turned else solid, 1, turned
    together = (body == "all" or (body is None and pressed_up)) and not turned
    if together and (not unite or are_apart(bodies)):
        return solid, len(bodies), turned
    chosen, changes = _choose(bodies, body, pressed_up)
    return chosen, len(bodies), turned + changes


def _choose(bodies: list[Body], body: int | str | None, pressed_up: bool) -> tuple[Solid, list[str]]:
    if isinstance(body, str) and body != "all":
        raise SolidError(f"body {body!r} does not exist; this format has no names; {_listed(bodies)}")
    if isinstance(body, int):
        if not 1 <= body <= len(bodies):
            raise SolidError(f"body {body} does not exist; {_listed(bodies)}")
        return bodies[body - 1].solid, []
    if body is None and not pressed_up:
        hint = "expected body = a number, or 'all' to unite them"
        raise BodiesError(f"{_listed(bodies)}; {hint}", len(bodies))
    united = union([one.solid for one in bodies])
    total = sum(one.volume_mm3 for one in bodies)
    overlap = total - united.volume_mm3
    notes = (
        f"{len(bodies)} bodies united; overlaps of {overlap:.6g} mm³ now count once; "
        f"{volume_change(total, united.volume_mm3)}"
    )
    return united, [notes] if abs(overlap) > 1e-9 * total else []


def _listed(bodies: list[Body]) -> str:
    lines = []
    for number, one in enumerate(bodies, start=1):
        x, y, z = one.size_mm
        lines.append(f"{number}: {one.volume_mm3:.6g} mm³, {x:.5g} × {y:.5g} × {z:.5g} mm")
    return listed(lines)
