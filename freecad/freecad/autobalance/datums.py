"""What is recognised on a crank, as objects of the document: axis, journals, crankpins, webs, faces."""

import Part
from FreeCAD import Rotation, Vector
from freecad.autobalance.cuts import to_file

PAST_MM = 10.0
"""How far the axis stands out of the crank."""
NEAR_MM = 0.01


def recognised(source, found):
    """Return a group of datum objects; ``found`` is the report of ``inspect``."""
    document, frame = source.Document, to_file(found)
    group = document.addObject("App::DocumentObjectGroup", "Recognised")
    along = frame.Rotation.multVec(Vector(0, 0, 1))

    def add(name, label, shape):
        shown = document.addObject("Part::Feature", name)
        shown.Label, shown.Shape = label, shape
        group.addObject(shown)

    def at(z):
        return frame.multVec(Vector(0, 0, z))

    crank = found["crank"]
    journals, throws, webs = crank["main_journals"], crank["throws"], crank["webs"]
    ends = [pin["centre_mm"][2] + side * 0.5 * pin["width_mm"] for pin in journals for side in (-1.0, 1.0)]
    ends += [web[key] for web in webs for key in ("z_min_mm", "z_max_mm")]
    add("CrankAxis", "Crank axis", Part.makeLine(at(min(ends) - PAST_MM), at(max(ends) + PAST_MM)))
    for name, pins in (("Main journal", journals), ("Crankpin", throws)):
        for each in pins:
            pin = each.get("crankpin", each)
            start = Vector(*pin["centre_mm"]) - Vector(0, 0, 0.5 * pin["width_mm"])
            shape = Part.makeCylinder(0.5 * pin["diameter_mm"], pin["width_mm"], frame.multVec(start), along)
            add(name.replace(" ", ""), "%s %d" % (name, each["number"]), shape)
    for web in webs:
        add("Web", "Web %d" % web["number"], web_shape(source, web, at, along))
    for face in found.get("faces", []):
        add("Face", "Face %s" % face["id"], face_shape(source, face, frame))
    return group


def web_shape(source, web, at, along):
    """Return the metal of a web; of a mesh the two circles of its ends."""
    low, high = web["z_min_mm"], web["z_max_mm"]
    if hasattr(source, "Mesh"):
        radius = 0.5 * source.Mesh.BoundBox.DiagonalLength
        return Part.makeCompound([Part.makeCircle(radius, at(z), along) for z in (low, high)])
    solid = source.Shape.Solids[0]
    return solid.common(Part.makeCylinder(solid.BoundBox.DiagonalLength, high - low, at(low), along))


def face_shape(source, face, frame):
    """Return the face of the solid that is meant; where none is, a disc of its area."""
    centre = Vector(*face["file_centroid_mm"])
    for each in [] if hasattr(source, "Mesh") else source.Shape.Faces:
        if each.CenterOfMass.distanceToPoint(centre) < NEAR_MM:
            return each.copy()
    normal = frame.Rotation.multVec(Vector(*face["normal"]))
    disc = Part.Face(Part.Wire(Part.makeCircle((face["area_mm2"] / 3.14159265) ** 0.5)))
    disc.Placement.Base, disc.Placement.Rotation = centre, Rotation(Vector(0, 0, 1), normal)
    return disc
