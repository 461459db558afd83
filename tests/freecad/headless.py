"""The workbench without a window; run by ``freecadcmd`` (see ``make freecad``), ends with 0 or 1.

Each check prints a line. Cranks are built by the command itself; nothing of the package is imported.
"""

import json
import os
import shutil
import sys
import tempfile
import time
import traceback

import FreeCAD
import Part

ROOT = os.environ["AUTOBALANCE_ROOT"]
import freecad  # noqa: E402

freecad.__path__.append(os.path.join(ROOT, "freecad", "freecad"))
from freecad.autobalance import commands, cuts, program  # noqa: E402
from freecad.autobalance import crank as cranks  # noqa: E402

KINDS = {
    "drill": ("drill.diameters_mm=[10.0]",),
    "axial": ('drill.direction="axial"', "drill.diameters_mm=[10.0]"),
    "slug": ("slug.diameters_mm=[12.0]", "slug.lengths_mm=[8.0, 12.0]"),
    "mill": (),
    "shoulder": (),
    "turn": (),
    "add": (),
    "mixed": ('method=["add", "slug"]', "slug.diameters_mm=[12.0]", "slug.lengths_mm=[8.0, 12.0]"),
}
QUICK_KINDS = ("shoulder", "slug")
"""A face that is rebuilt, and holes with metal in them: what `make freecad-quick` tries."""
REMOVED = 1e-5
"""Share by which a cut that FreeCAD rebuilds may take more or less than is listed."""
FOLLOWS = 1e-5
"""Share of the metal taken by which the native tree may differ from the corrected solid."""
RESIDUAL = 0.01
"""Share of the permissible unbalance by which FreeCAD's residual may differ."""


DRAWN = []
"""The crank of most checks, once it is drawn."""


def document(name="check"):
    made = FreeCAD.newDocument(name)
    if not DRAWN:
        source = commands.new_crank("single", made)
        DRAWN.append(source.Shape.copy())
        return made, source
    source = made.addObject("Part::Feature", "Crank")
    source.Shape = DRAWN[0]
    return made, source


def balanced(kind, made, source):
    obj = cranks.make_crank(source, made)
    obj.Method = {"axial": "drill", "mixed": "add"}.get(kind, kind)
    obj.Limits = list(KINDS[kind])
    obj.Rotating, obj.Reciprocating = [300.0], [300.0]
    obj.Factor, obj.Grade = {"slug": 0.3, "add": 0.3, "mixed": 0.35}.get(kind, 0.12), 40.0
    made.recompute()
    assert obj.Outcome, "the command did not end: see above"
    return obj


def check_kind(kind):
    """Each cut, rebuilt by FreeCAD from the report alone, takes what is listed; so does their tree."""
    made, source = document()
    obj = balanced(kind, made, source)
    report = json.loads(obj.Report)
    assert len({cut["kind"] for cut in report["corrections"]}) == (2 if kind == "mixed" else 1), kind
    tree = commands.make_cuts(obj)
    worst = 0.0
    left = source.Shape.Solids[0]
    for place, cut in enumerate(report["corrections"]):
        tool = next(each for each in made.Objects if each.Label == cut["label"])
        adds = cut["kind"] == "add"
        metal = tool.Shape.cut(left) if adds else left.common(tool.Shape)
        share = abs(cuts.volume_mm3(metal) / abs(cut["removed_volume_mm3"]) - 1.0)
        worst, left = max(worst, share), left.fuse(tool.Shape) if adds else left.cut(tool.Shape)
        assert share <= REMOVED, (kind, place, share)
    x, y = cuts.residual_by_freecad(obj, tree.Shape)
    u, v = report["residual"]["unbalance_g_mm"]
    off = ((x - u) ** 2 + (y - v) ** 2) ** 0.5 / obj.Permissible
    assert off <= RESIDUAL, (kind, off)
    (shown,) = [each for each in made.Objects if hasattr(each, "ByFreeCAD")]
    assert abs(shown.ByFreeCAD - (x * x + y * y) ** 0.5) < 1e-9 and abs(shown.ByReport - obj.Residual) < 1e-9
    assert shown.Apart <= RESIDUAL
    if kind in ("add", "drill"):
        check_kept(obj, tree, made, shown)
    print(
        "%s: %d cuts, volume within %.1e, residual within %.2f %%"
        % (kind, len(report["corrections"]), worst, 100 * off)
    )
    FreeCAD.closeDocument(made.Name)


def taken_mm3(obj, shape):
    """Return what a shape made of a crank's source has lost: FreeCAD's volume of a whole crank is 3e-6 off."""
    source = obj.Source.Shape
    return cuts.volume_mm3(source.cut(shape)) - cuts.volume_mm3(shape.cut(source))


def check_kept(obj, tree, made, shown):
    """The same cuts with new depths, then none: their number stays, and the native tree follows."""
    first = list(obj.Depths)
    obj.Plan, obj.Reciprocating = "kept", [290.0]
    made.recompute()
    assert len(obj.Depths) == len(first) and list(obj.Depths) != first, (first, list(obj.Depths))
    apart = taken_mm3(obj, tree.Shape) - taken_mm3(obj, obj.Shape)
    assert abs(apart) < FOLLOWS * abs(taken_mm3(obj, obj.Shape)), ("the native tree does not follow", apart)
    assert shown.Apart <= RESIDUAL and abs(shown.ByReport - obj.Residual) < 1e-9
    obj.Factor, count = json.loads(obj.Report)["balance_factor"]["initial"], len(first)
    made.recompute()
    assert list(obj.Depths) == [0.0] * count, list(obj.Depths)
    assert abs(taken_mm3(obj, tree.Shape)) < 1e-3, ("a cut of depth 0 cuts", taken_mm3(obj, tree.Shape))


def check_spreadsheet():
    """A cell drives the weights: the solid follows; nothing runs where nothing has changed; all is saved."""
    made, source = document()
    sheet = made.addObject("Spreadsheet::Sheet", "Sheet")
    sheet.set("B1", "300")
    sheet.set("B2", "300")
    made.recompute()
    obj = cranks.make_crank(source, made)
    obj.Method, obj.Factor, obj.Grade = "drill", 0.12, 40.0
    obj.Limits = ["drill.diameters_mm=[10.0]"]
    obj.setExpression("Rotating", "list(Sheet.B1)")
    obj.setExpression("Reciprocating", "list(Sheet.B2)")
    made.recompute()
    first, volume, hash_ = list(obj.Depths), obj.Shape.Volume, obj.InputHash
    assert first and list(obj.Reciprocating) == [300.0]
    tree = commands.make_cuts(obj)
    obj.touch()
    made.recompute()
    assert obj.InputHash == hash_
    obj.Plan = "kept"
    sheet.set("B2", "280")
    made.recompute()
    assert len(obj.Depths) == len(first) and list(obj.Depths) != first, (first, obj.Depths)
    assert obj.Shape.Volume != volume
    assert "plan_kept" in json.loads(obj.Report)
    apart = taken_mm3(obj, tree.Shape) - taken_mm3(obj, obj.Shape)
    assert abs(apart) < FOLLOWS * taken_mm3(obj, obj.Shape), ("the native tree does not follow", apart)
    path = os.path.join(tempfile.mkdtemp(), "saved.FCStd")
    depths = list(obj.Depths)
    made.saveAs(path)
    FreeCAD.closeDocument(made.Name)
    again = FreeCAD.openDocument(path)
    found = next(each for each in again.Objects if hasattr(each, "InputHash"))
    assert list(found.Depths) == depths
    found.touch()
    again.recompute()
    assert found.InputHash and list(found.Depths) == depths
    print("spreadsheet: depths %s then %s, kept, saved and opened" % (first, depths))
    FreeCAD.closeDocument(again.Name)


def check_thesis():
    """The case of the thesis: the drafted crank, its weights in a spreadsheet, shoulders of 2.787 mm."""
    import Mesh

    made = FreeCAD.newDocument("thesis")
    source = made.addObject("Mesh::Feature", "Crank")
    source.Mesh = Mesh.Mesh(os.path.join(ROOT, "fixtures", "crf250r", "drafted", "crank.stl"))
    sheet = made.addObject("Spreadsheet::Sheet", "Weights")
    for cell, value in {"B1": 95.04, "B2": 39.00, "B3": 261.5, "B4": 114.65}.items():
        sheet.set(cell, str(value))
    made.recompute()
    obj = cranks.make_crank(source, made)
    obj.CrankpinInFile, obj.Factor, obj.Grade, obj.SpeedRpm = False, 0.28, 6.3, 15200.0
    obj.Method = "shoulder"
    obj.Limits = limits_of_the_thesis()
    obj.setExpression("Rotating", "list(Weights.B1; Weights.B2)")
    obj.setExpression("Reciprocating", "list(Weights.B3)")
    obj.setExpression("Crankpin", "list(Weights.B4)")
    made.recompute()
    assert obj.Depths, obj.Reason
    assert all(abs(depth - 2.787) < 5e-3 for depth in obj.Depths), list(obj.Depths)
    print("thesis: depths %s mm" % ["%.3f" % depth for depth in obj.Depths])
    FreeCAD.closeDocument(made.Name)


def check_job():
    """What is written as a job is what is run; a mesh has a tree of cuts, too; odd sizes are named."""
    import tomllib

    import MeshPart

    made, source = document()
    mesh = made.addObject("Mesh::Feature", "Mesh")
    mesh.Mesh = MeshPart.meshFromShape(
        Shape=source.Shape.Solids[0], LinearDeflection=0.2, AngularDeflection=0.5
    )
    obj = cranks.make_crank(mesh, made)
    obj.Method, obj.Rotating, obj.Reciprocating, obj.Factor, obj.Grade = "drill", [300.0], [300.0], 0.12, 40.0
    obj.Drills, obj.Limits = (
        [12.0],
        ["drill.diameters_mm = [10.0]", "drill.direction=radial", "min_wall_mm=2.5"],
    )
    folder = tempfile.mkdtemp()
    with open(cranks.write_job(obj, folder), "rb") as stream:
        table = tomllib.load(stream)["correction"]
    wanted = {"method": "drill", "min_wall_mm": 2.5, "drill": {"diameters_mm": [10.0], "direction": "radial"}}
    assert table == wanted, table
    assert cranks.balanceable(obj) == [mesh, source]
    assert cranks.size_of(source, 7850.0).endswith(" × 94.26 × 152 mm, 1857 g"), cranks.size_of(
        source, 7850.0
    )
    made.recompute()
    depths, obj.Limits, obj.JobFile = list(obj.Depths), [], os.path.join(folder, "job.toml")
    made.recompute()
    assert depths and list(obj.Depths) == depths, (depths, list(obj.Depths), obj.Problem)
    tree = commands.make_cuts(obj)
    (shown,) = [each for each in made.Objects if hasattr(each, "ByFreeCAD")]
    assert shown.Apart <= RESIDUAL and tree.Shape.Volume < mesh.Mesh.Volume
    print(
        "job: limits written, a mesh's tree of %d cuts, %s"
        % (len(obj.Depths), cranks.size_of(source, 7850.0))
    )
    FreeCAD.closeDocument(made.Name)


def check_mesh(kind):
    """A kind's cuts of a mesh, rebuilt as native features, leave the residual of the report."""
    import MeshPart

    made, source = document()
    mesh = made.addObject("Mesh::Feature", "Mesh")
    mesh.Mesh = MeshPart.meshFromShape(
        Shape=source.Shape.Solids[0], LinearDeflection=0.2, AngularDeflection=0.5
    )
    obj = balanced(kind, made, mesh)
    assert len(obj.Depths), (obj.Reason, obj.Problem)
    commands.make_cuts(obj)
    (shown,) = [each for each in made.Objects if hasattr(each, "ByFreeCAD")]
    assert shown.Apart <= RESIDUAL, shown.Apart
    print(
        "mesh, %s: %d cuts, residual within %.2f %%" % (kind, len(obj.Depths), 100 * shown.Apart), flush=True
    )
    FreeCAD.closeDocument(made.Name)


def limits_of_the_thesis():
    """Return the keys of the bundled job's [correction] but its method."""
    import tomllib

    with open(os.path.join(ROOT, "fixtures", "crf250r", "drafted", "factor-0.28.toml"), "rb") as stream:
        table = tomllib.load(stream)["correction"]
    return ["%s=%s" % (key, json.dumps(value)) for key, value in table.items() if key != "method"]


def check_inspect():
    """Axis, journals, crankpins, webs and faces stand where the crank has them; a mesh has them too."""
    import Mesh
    import MeshPart

    made, source = document()
    solid = source.Shape.Solids[0]
    mesh = made.addObject("Mesh::Feature", "Mesh")
    mesh.Mesh = MeshPart.meshFromShape(solid, 0.02, 0.1)
    for each in (source, mesh):
        group = commands.inspect(each)
        labels = [item.Label for item in group.Group]
        for name, count in (("Crank axis", 1), ("Main journal", 2), ("Crankpin", 1), ("Web", 2)):
            assert sum(label.startswith(name) for label in labels) == count, (name, labels)
        shown = {item.Label: item.Shape for item in group.Group}
        axis = next(shape for label, shape in shown.items() if label.startswith("Crank axis"))
        assert axis.Length > solid.BoundBox.DiagonalLength * 0.5
        faces = [shape for label, shape in shown.items() if label.startswith("Face ")]
        assert faces and all(shape.Area > 1.0 for shape in faces)
        if each is source:
            webs = [shape for label, shape in shown.items() if label.startswith("Web")]
            assert 0.1 * solid.Volume < sum(web.Volume for web in webs) < solid.Volume
            known = [face.CenterOfMass for face in solid.Faces]
            places = [shape.CenterOfMass for shape in faces]
            assert all(min(place.distanceToPoint(one) for one in known) < 0.01 for place in places)
    assert isinstance(mesh.Mesh, Mesh.Mesh)
    print("inspect: axis, journals, crankpin, webs and %d faces, of a solid and of a mesh" % len(faces))
    FreeCAD.closeDocument(made.Name)


def check_refusals():
    """Each thing that cannot be is one line, and nothing is changed."""
    made, source = document()
    count = len(made.Objects)
    two = made.addObject("Part::Feature", "Two")
    two.Shape = Part.makeCompound([Part.makeBox(1, 1, 1), Part.makeBox(1, 1, 1, FreeCAD.Vector(5, 0, 0))])
    flat = made.addObject("Part::Feature", "Sketch")
    flat.Shape = Part.makeCircle(3.0)
    for wrong, why in ((None, "nothing is selected"), (two, "2 solids"), (flat, "no solid")):
        try:
            cranks.make_crank(wrong, made)
        except program.CommandError as error:
            assert why in str(error) and "\n" not in str(error), error
        else:
            raise AssertionError("%s was taken" % why)
    assert len(made.Objects) == count + 2
    obj = balanced("drill", made, source)
    volume, report = obj.Shape.Volume, obj.Report
    obj.SpeedRpm, obj.Grade = -1.0, -1.0
    made.recompute()
    assert [each.split()[1] for each in obj.Problem.splitlines()] == ["balance.grade", "balance.speed_rpm"], (
        obj.Problem
    )
    obj.Grade = 40.0
    for change, why in (
        (lambda: setattr(obj, "SpeedRpm", -1.0), "speed_rpm"),
        (
            lambda: (
                setattr(obj, "SpeedRpm", 6000.0),
                setattr(obj, "Factor", 0.2),
                os.environ.__setitem__("AUTOBALANCE_COMMAND", "/nowhere/autobalance"),
            ),
            "not at /nowhere",
        ),
    ):
        change()
        try:
            obj.Proxy.balance(obj)
        except program.CommandError as error:
            assert why in str(error) and "\n" not in str(error), error
        else:
            raise AssertionError("%s was taken" % why)
        assert (obj.Shape.Volume, obj.Report) == (volume, report)
        made.recompute()
        assert why in obj.Problem and obj.isValid(), (obj.Problem, obj.State)
        assert (obj.Shape.Volume, obj.Report) == (volume, report)
    os.environ["AUTOBALANCE_COMMAND"] = COMMAND
    obj.Proxy.cancelled = lambda: True
    try:
        obj.Proxy.balance(obj)
    except program.CommandError as error:
        assert "cancelled" in str(error)
    else:
        raise AssertionError("it was not cancelled")
    assert (obj.Shape.Volume, obj.Report) == (volume, report)
    obj.Proxy.loads({"version": 99})
    obj.Proxy.onDocumentRestored(obj)
    assert obj.Report == report
    print("refusals: no selection, two solids, a sketch, a bad job, no command, a cancel, another version")
    FreeCAD.closeDocument(made.Name)


COMMAND = os.environ["AUTOBALANCE_COMMAND"]


def main():
    failed = 0
    is_quick = bool(os.environ.get("AUTOBALANCE_QUICK"))
    kinds = QUICK_KINDS if is_quick else KINDS
    checks = [("kind " + kind, lambda kind=kind: check_kind(kind)) for kind in kinds]
    checks += [("spreadsheet", check_spreadsheet), ("thesis", check_thesis), ("job", check_job)]
    checks += [("inspect", check_inspect), ("refusals", check_refusals)]
    if not is_quick:
        checks += [("mesh " + kind, lambda kind=kind: check_mesh(kind)) for kind in KINDS]
    part, parts = (int(each) for each in os.environ.get("AUTOBALANCE_PART", "1/1").split("/"))
    checks = checks[part - 1 :: parts]
    wanted = os.environ.get("AUTOBALANCE_CHECKS", "")
    for name, check in checks:
        if wanted and wanted not in name:
            continue
        begun = time.monotonic()
        try:
            check()
            print("  %s took %.0f s" % (name, time.monotonic() - begun), flush=True)
        except BaseException:
            failed += 1
            print("FAILED: %s" % name)
            traceback.print_exc(file=sys.stdout)
    print("%d failed" % failed)
    sys.stdout.flush()
    shutil.rmtree(os.environ.get("FREECAD_USER_HOME", "") or "/nonexistent", ignore_errors=True)
    os._exit(int(failed > 0))


main()
