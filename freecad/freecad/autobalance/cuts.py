"""The cuts of a report as native features: cylinders and cones, extruded outlines, turned rims.

Depths are bound to the balanced crank's ``Depths`` by expressions; outlines of faces, which change with the
depth, are features of their own that read the crank's report. All in the coordinates of the crank's file.
"""

import json
import math

import FreeCAD
import Part
from FreeCAD import Matrix, Placement, Vector

FAR_MM = 1.0
"""How far a pocket's tool begins outside of the metal."""
OUTSIDE_MM = 0.5
"""Length of a bore that is not drilled, from where its tool begins, which is 1 mm or more over the metal."""
BESIDE_MM = 1.0
SPECK_MM = 0.1
"""How far from its face, and how wide, what is drawn of a face that is not cut."""
THIN_MM = 1e-3
"""Least length of a pad: FreeCAD makes none of 0."""


def make_cuts(crank):
    """Return the tree of a balanced crank: every cut's tool, and the source less or plus them.

    Returns
    -------
    Part::Cut or Part::MultiFuse
    """
    report = json.loads(crank.Report)
    document = crank.Document
    group = document.addObject("App::DocumentObjectGroup", "Cuts")
    source = solid_source(crank, group)
    taken, added = [], []
    for place, cut in enumerate(report["corrections"]):
        tool = make_tool(crank, report, place)
        tool.Label = cut["label"]
        group.addObject(tool)
        (added if cut["kind"] == "add" else taken).append(tool)
    result = source
    for tools, kind in ((added, "Part::MultiFuse"), (taken, "Part::Cut")):
        if not tools:
            continue
        made = document.addObject(kind, "NativeCrank")
        if kind == "Part::Cut":
            made.Base, made.Tool = result, _fused(document, group, tools)
        else:
            made.Shapes = [result, *tools]
        result = made
    if result is not source:
        Residual(document.addObject("App::FeaturePython", "TreeResidual"), crank, source, result)
    document.recompute()
    return result


def solid_source(crank, group):
    """Return the feature that the tools are cut from: the source, or a mesh's solid of flat faces."""
    source = crank.Source
    if not hasattr(source, "Mesh"):
        return source
    solid = crank.Document.addObject("Part::Feature", "SourceSolid")
    solid.Shape = mesh_shape(source.Mesh)
    group.addObject(solid)
    return solid


def mesh_shape(mesh):
    """Return a mesh as a solid of flat faces."""
    shell = Part.Shape()
    shell.makeShapeFromMesh(mesh.Topology, 1e-4)
    return Part.makeSolid(shell) if shell.isClosed() else shell


class Residual:
    """FreeCAD's own residual of the tree of cuts, from its B-rep, beside the report's; it follows both."""

    def __init__(self, obj, crank, source, tree):
        obj.Proxy = self
        for name, linked in (("Crank", crank), ("Before", source), ("Tree", tree)):
            obj.addProperty("App::PropertyLink", name, "Cuts", "What it is measured on")
            setattr(obj, name, linked)
        for name, words in (
            ("ByFreeCAD", "Residual of the tree as FreeCAD measures it, in g mm"),
            ("ByReport", "Residual of the report, in g mm"),
            ("Apart", "Their difference as a share of the permissible unbalance"),
        ):
            obj.addProperty("App::PropertyFloat", name, "Residual", words)
            obj.setEditorMode(name, 1)

    def execute(self, obj):
        """Measure."""
        x, y = residual_by_freecad(obj.Crank, obj.Tree.Shape, obj.Before.Shape)
        u, v = json.loads(obj.Crank.Report)["residual"]["unbalance_g_mm"]
        obj.ByFreeCAD, obj.ByReport = math.hypot(x, y), math.hypot(u, v)
        obj.Apart = math.hypot(x - u, y - v) / obj.Crank.Permissible

    def dumps(self):
        """Save nothing."""
        return

    def loads(self, state):
        """Take nothing."""

    __getstate__, __setstate__ = dumps, loads


def residual_of(crank):
    """Return the residual object of a crank's tree; None without a tree."""
    return next((each for each in crank.InList if hasattr(each, "ByFreeCAD")), None)


def _fused(document, group, tools):
    if len(tools) == 1:
        return tools[0]
    fuse = document.addObject("Part::MultiFuse", "Tools")
    fuse.Shapes = tools
    group.addObject(fuse)
    return fuse


def to_file(report):
    """Return the placement from the rotor frame to file coordinates."""
    rows = report["frame"]["file_to_rotor"]
    return Placement(Matrix(*[value for row in rows for value in row])).inverse()


def make_tool(crank, report, place):
    """Return the native tool of a correction."""
    cut = report["corrections"][place]
    makers = {"drill": _hole, "slug": _hole, "mill": _pocket, "turn": _rim, "shoulder": _face, "add": _face}
    if cut["kind"] not in makers:
        raise ValueError("cuts of kind %s are not known here" % cut["kind"])
    return makers[cut["kind"]](crank, report, place)


def _depth(crank, place):
    return "%s.Depths[%d]" % (crank.Name, place)


def _hole(crank, report, place):
    """Return a cylinder from outside the entry, with the cone of the point."""
    cut, document = report["corrections"][place], crank.Document
    axis = Vector(*cut["file_axis"])
    turn = FreeCAD.Rotation(Vector(0, 0, 1), axis)
    entry = Vector(*cut["file_position_mm"])
    lift, radius, point = cut["entry_lift_mm"], 0.5 * cut["diameter_mm"], cut["point_mm"]
    bore = document.addObject("Part::Cylinder", "Bore")
    bore.Radius = radius
    bore.Placement = Placement(entry - axis * lift, turn)
    depth = _depth(crank, place)  # where it is 0 nothing is cut: bore and point end outside of the metal
    bore.setExpression("Height", "(%s > 0 ? %s + %.15g : %g) * 1mm" % (depth, depth, lift, OUTSIDE_MM))
    if point <= 0.0:
        return bore
    cone = document.addObject("Part::Cone", "Point")
    cone.Radius1, cone.Radius2, cone.Height = radius, 0.0, point
    cone.Placement = Placement(entry + axis * cut["depth_mm"], turn)
    away = -(lift + point)
    for letter, start, along in zip("xyz", entry, axis):
        words = "%.15g mm + (%s > 0 ? %s : %.15g) * %.15g mm" % (start, depth, depth, away, along)
        cone.setExpression("Placement.Base." + letter, words)
    hole = document.addObject("Part::MultiFuse", "Hole")
    hole.Shapes = [bore, cone]
    return hole


def _pocket(crank, report, place):
    """Return the pocket's outline, which stays, extruded by the depth."""
    cut = report["corrections"][place]
    outline = crank.Document.addObject("Part::Feature", "PocketOutline")
    lift = Placement(Vector(0, 0, cut["face_z_mm"] + cut["side"] * FAR_MM), FreeCAD.Rotation())
    outline.Shape = Part.Face(_pocket_wire(cut)).transformed(to_file(report).multiply(lift).toMatrix(), True)
    length = "%s * 1mm + %.15g mm" % (_depth(crank, place), FAR_MM)
    return _extruded(crank, outline, _along(report, -cut["side"]), length)


def _pocket_wire(cut):
    """Two arcs, two lines, four round corners."""
    corner, near, far = cut["corner_radius_mm"], cut["inner_radius_mm"], cut["outer_radius_mm"]
    start = math.radians(cut["start_deg"])
    end = start + math.radians((cut["end_deg"] - cut["start_deg"]) % 360.0)
    out, low = far - corner, near + corner
    lean, bend, quarter = math.asin(corner / out), math.asin(corner / low), 0.5 * math.pi
    corners = (
        (_polar(out, start + lean), start - quarter, start + lean),
        (_polar(out, end - lean), end - lean, end + quarter),
        (_polar(low, end - bend), end + quarter, end - bend + math.pi),
        (_polar(low, start + bend), start + bend + math.pi, start + 3.0 * quarter),
    )
    arcs = [_arc(centre, corner, a, b) for centre, a, b in corners]
    outer = _arc(Vector(), far, start + lean, end - lean)
    inner = _arc(Vector(), near, end - bend, start + bend)
    edges = [
        arcs[0],
        outer,
        arcs[1],
        _line(arcs[1], arcs[2]),
        arcs[2],
        inner,
        arcs[3],
        _line(arcs[3], arcs[0]),
    ]
    return Part.Wire(Part.__sortEdges__(edges))


def _polar(radius, angle):
    return Vector(radius * math.cos(angle), radius * math.sin(angle), 0.0)


def _arc(centre, radius, begin, end):
    """Return an arc; one that runs backward is the same edge."""
    low, high = sorted((begin, end))
    return Part.makeCircle(radius, centre, Vector(0, 0, 1), math.degrees(low), math.degrees(high))


def _line(one, other):
    """Return the line between the nearest ends of two arcs."""
    pairs = [(a.Point, b.Point) for a in one.Vertexes for b in other.Vertexes]
    begin, end = min(pairs, key=lambda pair: pair[0].distanceToPoint(pair[1]))
    return Part.makeLine(begin, end)


def _along(report, sign):
    """Return the rotor's axis in file coordinates."""
    return to_file(report).Rotation.multVec(Vector(0, 0, sign))


def _extruded(crank, outline, direction, length):
    solid = crank.Document.addObject("Part::Extrusion", "Pad")
    solid.Base, solid.DirMode, solid.Dir, solid.Solid = outline, "Custom", direction, True
    solid.setExpression("LengthFwd", length)
    return solid


def _rim(crank, report, place):
    """Return an outer cylinder less one of the new radius, which is bound to the depth."""
    cut, document = report["corrections"][place], crank.Document
    frame = to_file(report)
    base = frame.multVec(Vector(0, 0, cut["z_from_mm"]))
    made = []
    for name, radius in (("Outside", cut["outer_radius_mm"]), ("Inside", cut["new_radius_mm"])):
        round_ = document.addObject("Part::Cylinder", name)
        round_.Radius, round_.Height = radius, cut["z_to_mm"] - cut["z_from_mm"]
        round_.Placement = Placement(base, frame.Rotation)
        made.append(round_)
    made[1].setExpression("Radius", "%.15g mm - %s * 1mm" % (cut["rim_radius_mm"], _depth(crank, place)))
    ring = document.addObject("Part::Cut", "Ring")
    ring.Base, ring.Tool = made
    return ring


class Outline:
    """The outline of a face at its new height, read from the crank's report."""

    def __init__(self, obj, crank, place):
        obj.Proxy = self
        obj.addProperty("App::PropertyLink", "Crank", "Cut", "The balanced crank")
        obj.addProperty("App::PropertyInteger", "Place", "Cut", "Place among its cuts, from 0")
        obj.addProperty(
            "App::PropertyFloatList", "Depths", "Cut", "Those of the crank: bound, so that it follows"
        )
        obj.Crank, obj.Place = crank, place
        obj.setExpression("Depths", "%s.Depths" % crank.Name)

    def execute(self, obj):
        """Draw the outline at the new height."""
        report = json.loads(obj.Crank.Report)
        obj.Shape = outline_shape(report, obj.Place)

    def dumps(self):
        """Save nothing."""
        return

    def loads(self, state):
        """Take nothing."""

    __getstate__, __setstate__ = dumps, loads


def outline_shape(report, place):
    """Return the faces that an outline draws, file coordinates."""
    cut = report["corrections"][place]
    if not cut["depth_mm"]:  # a kept cut that is not needed: its feature stays, and cuts nothing
        return _speck(report, cut)
    wires = [Part.Wire(Part.__sortEdges__([_edge(each) for each in loop])) for loop in cut["outline"]]
    faces = []
    for wire, area in ((wire, _area(loop)) for wire, loop in zip(wires, cut["outline"])):
        if area > 0.0:
            faces.append([wire])
        else:
            faces[-1].append(wire)
    shape = Part.makeCompound([Part.Face(each) for each in faces])
    side = cut["side"]
    if side is None:
        rows = cut["outline_to_rotor"]
        frame = to_file(report).multiply(Placement(Matrix(*[value for row in rows for value in row])))
        height = cut["new_height_mm"]
    else:
        frame, height = to_file(report), side * cut["new_height_mm"]
    lift = Placement(Vector(0, 0, height), FreeCAD.Rotation())
    return shape.transformed(frame.multiply(lift).toMatrix(), True)  # a feature drops a shape's own placement


def _speck(report, cut):
    """Return a square over a face that loses nothing, or in the metal under one that gains nothing."""
    normal, at = Vector(*cut["normal"]), Vector(*cut["position_mm"])
    side = -BESIDE_MM if cut["kind"] == "add" else BESIDE_MM
    at = at + normal * (cut["face_height_mm"] + side - normal.dot(at))
    frame = to_file(report)
    return Part.makePlane(SPECK_MM, SPECK_MM, frame.multVec(at), frame.Rotation.multVec(normal))


def _edge(segment):
    if "line" in segment:
        (x0, y0), (x1, y1) = segment["line"]
        return Part.makeLine(Vector(x0, y0, 0), Vector(x1, y1, 0))
    arc = segment["arc"]
    begin, end = math.radians(arc["from_deg"]), math.radians(arc["to_deg"])
    return _arc(Vector(*arc["centre"], 0), arc["radius_mm"], begin, end)


def _area(loop):
    """Return twice the signed area of the polygon through a loop's ends and the middles of its arcs."""
    points = []
    for segment in loop:
        if "line" in segment:
            points.append(segment["line"][0])
            continue
        arc = segment["arc"]
        for share in (0.0, 0.25, 0.5, 0.75):
            angle = math.radians(arc["from_deg"] + share * (arc["to_deg"] - arc["from_deg"]))
            radius, (x, y) = arc["radius_mm"], arc["centre"]
            points.append((x + radius * math.cos(angle), y + radius * math.sin(angle)))
    pairs = zip(points, points[1:] + points[:1])
    return sum(x0 * y1 - x1 * y0 for (x0, y0), (x1, y1) in pairs)


def _face(crank, report, place):
    """Return the outline at the new height, extruded to the old one."""
    cut = report["corrections"][place]
    outline = crank.Document.addObject("Part::FeaturePython", "Outline")
    Outline(outline, crank, place)
    if FreeCAD.GuiUp:
        outline.ViewObject.Proxy = 0
    outline.recompute()
    normal = to_file(report).Rotation.multVec(Vector(*cut["normal"]))
    sign = -1.0 if cut["kind"] == "add" else 1.0
    lift = cut.get(
        "entry_lift_mm", 0.0
    )  # a shoulder begins up in a fillet where the kernel could only cut there
    length = "(max(abs(%s); %g) + %.15g) * 1mm" % (_depth(crank, place), THIN_MM, lift)
    return _extruded(crank, outline, normal * sign, length)


def residual_by_freecad(crank, shape, source=None):
    """Return the residual resultant [g mm] as FreeCAD measures a shape made of the crank's source.

    The report's initial unbalance less that of the metal that went, plus that of what came: FreeCAD measures
    small bodies to more digits than a whole crank, whose volume changes with its place by 3e-6.
    """
    report = json.loads(crank.Report)
    frame = to_file(report).inverse()
    source = source or crank.Source.Shape
    before = _moment(source.cut(shape), frame, crank.Density)
    after = _moment(shape.cut(source), frame, crank.Density)
    x, y = report["initial"]["unbalance_g_mm"]
    for cut in report["corrections"]:
        if cut.get("slug_mass_g") and cut["depth_mm"]:
            x += cut["slug_mass_g"] * cut["slug_centre_mm"][0]
            y += cut["slug_mass_g"] * cut["slug_centre_mm"][1]
    return x + after.x - before.x, y + after.y - before.y


def slabs(shape, count=8):
    """Yield a shape's solids cut across their longest side.

    FreeCAD integrates each face by a fixed number of points: 3e-5 of a hole through a round rim is
    lost, 1e-7 of its slabs.
    """
    for solid in shape.Solids:
        box = solid.BoundBox
        low = [box.XMin - 1.0, box.YMin - 1.0, box.ZMin - 1.0]
        lengths = [box.XLength, box.YLength, box.ZLength]
        longest = max(range(3), key=lengths.__getitem__)
        size = [length + 2.0 for length in lengths]
        size[longest] = (lengths[longest] + 2.0) / count
        for place in range(count):
            corner = list(low)
            corner[longest] += place * size[longest]
            yield from solid.common(Part.makeBox(*size, Vector(*corner))).Solids


def volume_mm3(shape):
    """Return the volume of a cut's metal to 1e-6."""
    return sum(piece.Volume for piece in slabs(shape))


def _moment(shape, frame, density):
    """Return mass times centre in the rotor frame."""
    total = Vector()
    for piece in slabs(shape):
        total = total + frame.multVec(piece.CenterOfMass) * (piece.Volume * density * 1e-6)
    return total
