"""The balanced crank: a parametric object whose solid is cut anew whenever geometry or a property changes."""

import hashlib
import json
import os
import shutil
import tempfile

import FreeCAD
import Part
from freecad.autobalance import program
from freecad.autobalance.cuts import mesh_shape
from freecad.autobalance.job import job_of, toml

VERSION = 1
METHODS = ("shoulder", "drill", "mill", "turn", "slug", "add")
PLANS = ("new", "kept")
PROPERTIES = (
    ("App::PropertyLink", "Source", "Source", "Body, solid or mesh of the crank", None),
    ("App::PropertyFloat", "Density", "Source", "Density in kg/m3", 7850.0),
    ("App::PropertyBool", "CrankpinInFile", "Source", "Whether the crankpin is part of the solid", True),
    ("App::PropertyFloatList", "Rotating", "Parts", "Rotating weights of a throw in g", [0.0]),
    ("App::PropertyFloatList", "Reciprocating", "Parts", "Reciprocating weights of a throw in g", [0.0]),
    ("App::PropertyFloatList", "Crankpin", "Parts", "Weights of a pressed-in crankpin in g", []),
    ("App::PropertyFloat", "RodLength", "Parts", "Rod length in mm, for the curve of factors; 0: none", 0.0),
    ("App::PropertyFloat", "Factor", "Balance", "Balance factor, 0 to 1", 0.5),
    ("App::PropertyFloat", "Grade", "Balance", "Balance quality grade G", 6.3),
    ("App::PropertyFloat", "SpeedRpm", "Balance", "Highest service speed in 1/min", 6000.0),
    ("App::PropertyEnumeration", "Method", "Correction", "Kind of correction", METHODS),
    (
        "App::PropertyFloatList",
        "Drills",
        "Correction",
        "Drills at hand in mm; none: the program's choice",
        [],
    ),
    ("App::PropertyStringList", "Limits", "Correction", "Keys of the job, key=value each, as --set", []),
    ("App::PropertyFile", "JobFile", "Correction", "A job file in place of all of these", ""),
    ("App::PropertyEnumeration", "Plan", "Correction", "new, or kept: the same cuts, new depths", PLANS),
)
RESULTS = (
    ("App::PropertyString", "Outcome", "Within or above tolerance"),
    ("App::PropertyString", "Reason", "Why it is above tolerance"),
    ("App::PropertyString", "Problem", "Why the last run failed: the solid is that of the run before"),
    ("App::PropertyFloat", "Residual", "Residual unbalance in g mm"),
    ("App::PropertyFloat", "Permissible", "Permissible residual unbalance in g mm"),
    ("App::PropertyFloat", "FactorBefore", "Balance factor before"),
    ("App::PropertyFloat", "FactorAfter", "Balance factor after"),
    ("App::PropertyFloatList", "Depths", "Depths of the cuts in mm, in their order"),
    ("App::PropertyString", "Report", "report.json"),
    ("App::PropertyString", "InputHash", "Of geometry and properties when it was balanced"),
)


class BalancedCrank:
    """The proxy of the object; only its version is saved with the document."""

    def __init__(self, obj):
        self.version, self.tell, self.cancelled = VERSION, None, None
        obj.Proxy = self
        add_properties(obj)

    def onDocumentRestored(self, obj):
        """Add what an earlier version did not have; its values and its shape stay."""
        self.tell = self.cancelled = None
        add_properties(obj)
        version = getattr(self, "version", 0)
        if version != VERSION:
            words = "%s was saved by version %s of the workbench; it is kept as it is"
            program.warn(words % (obj.Label, version))
            self.version = VERSION

    def execute(self, obj):
        """Balance anew if geometry or a property has changed; a failure is a line, and leaves all as it was.

        An error raised here would be a traceback in the report view beside that line.
        """
        try:
            self.balance(obj)
            obj.Problem = ""
        except program.CommandError as error:
            obj.Problem = program.complain(error, obj.Label)

    def balance(self, obj):
        """Balance anew if geometry or a property has changed.

        Raises
        ------
        CommandError
            If it fails; nothing is changed then.
        """
        wanted = input_hash(obj)
        if wanted == obj.InputHash and not obj.Shape.isNull():
            return
        shape, report = balanced(obj, self.tell, self.cancelled)
        obj.Shape = shape
        show_results(obj, report)
        obj.InputHash = wanted

    def dumps(self):
        """Return what is saved."""
        return {"version": VERSION}

    def loads(self, state):
        """Take what was saved."""
        self.version = state.get("version", 0) if isinstance(state, dict) else 0
        self.tell = self.cancelled = None

    __getstate__, __setstate__ = dumps, loads


def add_properties(obj):
    """Add the properties that an object has not yet."""
    for kind, name, group, words, usual in PROPERTIES:
        if not hasattr(obj, name):
            obj.addProperty(kind, name, group, words)
            if usual is not None:
                setattr(obj, name, list(usual) if isinstance(usual, tuple) else usual)
    for kind, name, words in RESULTS:
        if not hasattr(obj, name):
            obj.addProperty(kind, name, "Results", words)
            obj.setEditorMode(name, 1 if name not in ("Report", "InputHash") else 2)


def make_crank(source, document=None):
    """Return a balanced crank of an object; nothing is computed until the document is.

    Raises
    ------
    CommandError
        If it is no single solid.
    """
    check_source(source)
    document = document or source.Document
    obj = document.addObject("Part::FeaturePython", "BalancedCrank")
    BalancedCrank(obj)
    obj.Source = source
    if FreeCAD.GuiUp:
        obj.ViewObject.Proxy = 0
    return obj


def check_source(source):
    """Refuse what is no crank's solid, in one line."""
    if source is None:
        raise program.CommandError("nothing is selected; select the body of a crank")
    if hasattr(source, "Mesh"):
        return
    shape = getattr(source, "Shape", None)
    if shape is None or shape.isNull() or not shape.Solids:
        raise program.CommandError("%s is no solid; select a body, a solid or a mesh" % source.Label)
    if len(shape.Solids) > 1:
        raise program.CommandError(
            "%s has %d solids; expected one: unite them first" % (source.Label, len(shape.Solids))
        )


def balanceable(crank):
    """Return the objects of a document that may be a crank's source: its own first, other solids, meshes."""
    found = [crank.Source]
    for each in crank.Document.Objects:
        if each is crank or each in found or crank in each.OutListRecursive:
            continue
        try:
            check_source(each)
        except program.CommandError:
            continue
        found.append(each)
    return found


ODD_MM = (5.0, 5000.0)
"""Lengths between which a crank is taken for one."""


def size_of(source, density):
    """Return a body's size and mass as a text, by which a wrong unit is seen; ``density`` in kg/m³."""
    shape = source.Mesh if hasattr(source, "Mesh") else source.Shape.Solids[0]
    box = shape.BoundBox
    sizes = (box.XLength, box.YLength, box.ZLength)
    text = "%.4g × %.4g × %.4g mm, %.4g g" % (*sizes, shape.Volume * density * 1e-6)
    if not ODD_MM[0] <= max(sizes) <= ODD_MM[1]:
        text += "; odd for a crank: was the file's unit another? Scale the body, or import it anew"
    return text


def input_hash(obj):
    """Return a hash of all that the result depends on."""
    digest = hashlib.sha256()
    for _, name, group, _, _ in PROPERTIES:
        if group != "Source" or name != "Source":
            digest.update(repr((name, _plain(getattr(obj, name)))).encode())
    source = obj.Source
    if source is not None:
        if hasattr(source, "Mesh"):
            digest.update(repr([tuple(point) for point in source.Mesh.Topology[0]]).encode())
        else:
            digest.update(repr(geometry_of(source.Shape)).encode())
    if obj.JobFile and os.path.isfile(obj.JobFile):
        with open(obj.JobFile, "rb") as stream:
            digest.update(stream.read())
    return digest.hexdigest()


def geometry_of(shape):
    """Return numbers that change with a shape's geometry, not with what booleans leave on its edges."""
    corners = sorted(tuple(round(value, 6) + 0.0 for value in each.Point) for each in shape.Vertexes)
    faces = sorted((type(each.Surface).__name__, round(each.Area, 4)) for each in shape.Faces)
    return corners, faces


def _plain(value):
    return list(value) if isinstance(value, (list, tuple)) else value


def balanced(obj, tell=None, cancelled=None):
    """Return the corrected shape and the report of a balanced crank; files go through a temporary folder."""
    check_source(obj.Source)
    folder = tempfile.mkdtemp(prefix="autobalance-")
    try:
        words = ["balance", *job_words(obj, folder), "-o", os.path.join(folder, "out"), "--only", "json"]
        program.run(words, folder, tell, cancelled)
        with open(os.path.join(folder, "out", "report.json"), encoding="utf-8") as stream:
            report = json.load(stream)
        return shape_of(report, os.path.join(folder, "out"), obj.Source), report
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def write_source(source, folder):
    """Write a crank's solid or mesh to a folder; return the file's name."""
    file = "crank.stl" if hasattr(source, "Mesh") else "crank.step"
    path = os.path.join(folder, file)
    if hasattr(source, "Mesh"):
        source.Mesh.write(path)
    else:
        source.Shape.Solids[0].exportStep(path)
    return file


def job_words(obj, folder):
    """Write a crank's solid and its job to a folder; return the words of a command that reads that job."""
    words = [write_job(obj, folder)]
    if obj.JobFile:  # it may name another file, which is that of the crank elsewhere
        mesh = hasattr(obj.Source, "Mesh")
        words += ["--set", 'crankshaft.file="%s"' % ("crank.stl" if mesh else "crank.step")]
        words += ["--set", 'crankshaft.unit="mm"'] if mesh else []
    return words


def write_job(obj, folder):
    """Write a crank's solid and its job to a folder; return the path of the job."""
    check_source(obj.Source)
    file = write_source(obj.Source, folder)
    keep = None
    if obj.Plan == "kept" and obj.Report:
        keep = "kept.json"
        with open(os.path.join(folder, keep), "w", encoding="utf-8") as stream:
            stream.write(obj.Report)
    target = os.path.join(folder, "job.toml")
    if obj.JobFile:
        shutil.copy(obj.JobFile, target)
    else:
        with open(target, "w", encoding="utf-8") as stream:
            stream.write(toml(job_of(obj, file, keep)))
    return target


def shape_of(report, folder, source):
    """Return the shape that a run leaves: the written solid, or the source where nothing was cut."""
    solid = report["outputs"]["solid"]
    if solid is None:
        return source.Shape.Solids[0].copy() if not hasattr(source, "Mesh") else mesh_shape(source.Mesh)
    path = os.path.join(folder, solid["file"])
    if path.endswith(".stl"):
        import Mesh

        return mesh_shape(Mesh.Mesh(path))
    shape = Part.read(path)
    return shape.Solids[0] if len(shape.Solids) == 1 else shape


def show_results(obj, report):
    """Show a report in the result properties."""
    factor = report["balance_factor"]
    obj.Outcome = report["outcome"]
    obj.Reason = report["reason"] or ""
    obj.Residual = float(report["residual"]["magnitude_g_mm"])
    obj.Permissible = float(report["tolerance"]["permissible_g_mm"])
    obj.FactorBefore = float(factor["initial"] or 0.0)
    obj.FactorAfter = float(factor["final"] or 0.0)
    obj.Depths = [float(cut["depth_mm"]) for cut in report["corrections"]]
    obj.Report = json.dumps(report)
