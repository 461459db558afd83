"""A report's claims of a scan: its file beside a drawn crank, and its fit with the faces as they are now."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from autobalance.crank.anatomy import Anatomy
from autobalance.crank.datums import ScanFit, ScannedCylinder, ScannedOutline, ScannedWeb
from autobalance.crank.recognition.scanned import plane_faces
from autobalance.errors import FileError
from autobalance.job import Job
from autobalance.solid.mesh.mesh import Mesh
from autobalance.verification.claims import Claims
from autobalance.verification.solids import Files, check_source, input_path, read_input


def with_scan(claims: Claims, anatomy: Anatomy, mesh: Mesh) -> Anatomy:
    """Return the anatomy of a stage with the scan's fit; unchanged where the crank was drawn.

    The frame stays that of the first stage, and so do all standard errors in it: the crank is the same. Its
    faces are looked for in ``mesh``, the solid that was left, file coordinates [mm].
    """
    if "roughness_mm" not in claims.get("crank", dict):
        return anatomy
    throws = claims.entries("crank.throws")
    fit = ScanFit(
        roughness_mm=float(claims.get("crank.roughness_mm", float)),
        noise=(),  # a stage's uncertainty is that of its reading
        axis_offset_mm=float(claims.get("crank.axis_uncertainty.offset_mm", float)),
        axis_angle_deg=float(claims.get("crank.axis_uncertainty.angle_deg", float)),
        axis_middle_mm=0.0,
        journals=tuple(_cylinder(part) for part in claims.entries("crank.main_journals")),
        crankpins=tuple(_cylinder(part.at("crankpin", part.get("crankpin", dict))) for part in throws),
        crank_radius_pm_mm=tuple(float(part.get("crank_radius_pm_mm", float)) for part in throws),
        angle_pm_deg=tuple(float(part.get("angle_pm_deg", float)) for part in throws),
        webs=tuple(_web(part) for part in claims.entries("crank.webs")),
        faces=plane_faces(mesh, anatomy.file_to_rotor),
    )
    return replace(anatomy, scan=fit)


def with_scan_file(claims: Claims, folder: Path, job: Job, files: Files) -> Job:
    """Check the claims of the scan's file; return the job with the path where it was found.

    Raises
    ------
    FileError
        If it is missing: mass and unbalance could be claimed at will.
    """
    scan = job.crankshaft.scan
    if scan is None:
        return job
    path = input_path(claims, folder, "input.scan", "scan_file")
    if not path.is_file():
        raise FileError(
            f"{claims.name}: input.scan.file {path} is missing; expected the scan whose unbalance was cut"
        )
    check_source(claims, "input.scan", read_input(files, path, scan))
    claims.ledger.why_not["input.scan.file"] = f"it was found as {path}"
    return replace(job, crankshaft=replace(job.crankshaft, scan=replace(scan, file=path)))


def _cylinder(part: Claims) -> ScannedCylinder:
    cylinder = part.record(ScannedCylinder)
    if "journal_run_out_mm" not in part.values:
        return cylinder
    return replace(cylinder, run_out_mm=float(part.get("journal_run_out_mm", float)))


def _web(part: Claims) -> ScannedWeb:
    web = part.record(ScannedWeb)
    if part.values.get("outline") is None:
        return web
    outline = part.at("outline", part.get("outline", dict)).record(ScannedOutline)
    return replace(web, outline=outline)
