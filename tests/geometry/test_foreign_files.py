"""What a damaged CAD file does to the CAD kernel stays in a separate process, and is one line."""

from __future__ import annotations

import math
import os
import re
import signal
import threading
from pathlib import Path

import pytest

from autobalance.child_process import Child
from autobalance.errors import FormatError, SolidError
from autobalance.solid.cad import files, kernel
from autobalance.solid.cad.brep import ExactSolid
from autobalance.solid.cad.files import read_foreign_file
from autobalance.solid.cad.installed import has_kernel
from autobalance.solid.cad.kernel import properties
from autobalance.solid.cad.tessellation import bounds_mm
from autobalance.solid.csg.shape import Bar, Prism, Without, circle
from autobalance.solid.formats.read import read
from tests.libraries import installed_instead

pytestmark = pytest.mark.skipif(not has_kernel(), reason="the CAD kernel is not installed")

RING = Without(Prism(circle(20.0), 0.0, 30.0), (Bar((5.0, 0.0, -1.0), (5.0, 0.0, 31.0), 10.0),))


@pytest.fixture(scope="module")
def ring() -> ExactSolid:
    return ExactSolid(RING)


@pytest.fixture(scope="module")
def step(ring: ExactSolid) -> bytes:
    return ring.step("mm", "ring")


def without(step: bytes, name: str) -> bytes:
    """The file without the lines of one kind: the numbers that name them stay."""
    return re.sub(rb"#\d+ = %s\(.*?;\n" % name.encode(), b"", step, flags=re.DOTALL)


def test_a_solid_comes_back_from_the_other_process_to_the_bit(ring: ExactSolid, step: bytes) -> None:
    file = read_foreign_file("step", step)
    (one,) = file.bodies
    assert (one.name, file.unit, file.repairs) == ("ring", "mm", ())
    assert properties(one.body).mass_g == pytest.approx(math.pi * (400.0 - 25.0) * 30.0, rel=1e-12)
    here = kernel.properties(kernel.shape_of_bytes(kernel.shape_bytes(one.body)))
    assert here.mass_g == properties(one.body).mass_g


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("VECTOR", r"STEP file brings the CAD kernel down \(SIG[A-Z]+\);"),
        ("EDGE_LOOP", None),
        ("CARTESIAN_POINT", None),
    ],
)
def test_lines_that_are_gone_are_one_line(step: bytes, name: str, said: str | None, tmp_path: Path) -> None:
    path = tmp_path / "ring.step"
    path.write_bytes(without(step, name))
    with pytest.raises(FormatError if said else (FormatError, SolidError), match=said) as caught:
        read(path, None)
    assert "\n" not in str(caught.value)
    path.write_bytes(step)
    assert read(path, None).bodies == 1  # and the next file is read


@pytest.fixture
def reader(step: bytes) -> Child:
    """The process that reads the next file, which it will not before it is let go on."""
    read_foreign_file("step", step)
    (child,) = files.readers._idle
    child.process.send_signal(signal.SIGSTOP)
    return child


def test_a_reader_that_is_killed_is_one_line(step: bytes, reader: Child) -> None:
    threading.Timer(0.2, reader.process.kill).start()
    with pytest.raises(FormatError, match="SIGKILL"):
        read_foreign_file("step", step)
    assert read_foreign_file("step", step).unit == "mm"


def test_who_is_interrupted_leaves_no_reader_behind(step: bytes, reader: Child) -> None:
    def read_until_interrupted() -> None:
        threading.Timer(0.2, os.kill, (os.getpid(), signal.SIGINT)).start()
        read_foreign_file("step", step)

    with pytest.raises(KeyboardInterrupt):
        read_until_interrupted()
    assert reader.process.poll() is not None


def test_a_reader_that_takes_too_long_is_one_line(step: bytes) -> None:
    with pytest.raises(FormatError, match=r"keeps the CAD kernel busy for more than 0\.001 s; expected"):
        read_foreign_file("step", step, longest_s=1e-3)


def test_a_number_without_bounds_is_refused_and_such_a_name_is_not(step: bytes) -> None:
    """The kernel tessellated a curve with such a point for ever."""
    with pytest.raises(FormatError, match=r"has a number that ends in E\+30851596599; expected lengths"):
        read_foreign_file("step", step.replace(b"20.,", b"2.9E+30851596599,", 1))
    (one,) = read_foreign_file("step", step.replace(b"'ring'", b"'2E1000'")).bodies
    assert one.name == "2E1000"


@pytest.mark.parametrize("number", ["4294967296.", "1.E+30"])
def test_a_point_far_away_is_refused(step: bytes, number: str, tmp_path: Path) -> None:
    path = tmp_path / "far.step"
    path.write_bytes(step.replace(b"20.,", number.encode() + b",", 1))
    assert path.read_bytes() != step
    with pytest.raises((FormatError, SolidError)) as caught:
        read(path, None)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("packages", "expected"),
    [
        ((), True),  # brought by no package that is known
        (("cadquery_ocp_novtk-8.0.1", "cadquery_ocp_proxy-8.0.1"), True),
        (("cadquery_ocp-7.9.3.1.1", "cadquery_ocp_proxy-8.0.1"), False),
        (("cadquery_ocp-7.9.3.1.1", "cadquery_ocp_novtk-8.0.1"), True),  # whichever was unpacked last
    ],
)
def test_the_generation_of_a_kernel_is_known_without_loading_it(
    packages: tuple[str, ...], expected: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    installed_instead(monkeypatch, tmp_path, "OCP", "raise AssertionError('it was loaded')", packages)
    assert has_kernel() is expected


@pytest.mark.parametrize(
    "packages",
    [["cadquery_ocp-7.9.3.1"], ["cadquery_ocp-7.9.3.1", "cadquery_ocp_novtk-8.0.1"]],
    ids=["alone", "unpacked over the right one"],
)
def test_a_kernel_of_another_generation_is_named(
    packages: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    installed_instead(monkeypatch, tmp_path, "OCP", "__version__ = '7.9.3.1'", packages)
    with pytest.raises(FormatError, match=r"kernel OCP 8; found OCP 7\.9\.3\.1; .*pip install"):
        kernel.require_kernel("STEP")


def test_what_the_kernel_throws_is_one_line() -> None:
    from OCP.BRep import BRep_Builder
    from OCP.TopoDS import TopoDS_Compound

    empty = TopoDS_Compound()
    BRep_Builder().MakeCompound(empty)
    with (
        pytest.raises(SolidError, match=r"cannot compute the solid \(Bnd_Box is void\); expected"),
        kernel.kernel_failures("the solid"),
    ):
        bounds_mm(empty)
    with pytest.raises(SolidError, match="the shape is empty; expected a crankshaft's solid"):
        kernel.refuse_odd_shape(empty)
