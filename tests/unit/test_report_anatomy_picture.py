"""The picture of a crank: what is drawn where, without a screen."""

from __future__ import annotations

import struct
import zlib

import numpy as np

from autobalance.crank.faces import find_faces
from autobalance.report.pictures.picture import crank_picture
from autobalance.report.pictures.zbuffer import draw_labels, draw_line
from tests.cranks import Shape, make_crank, tilted


def pixels(png: bytes) -> np.ndarray:
    """Decode a PNG whose rows are filtered "up"."""
    assert png[:8] == b"\x89PNG\r\n\x1a\n"
    place, data, size = 8, b"", (0, 0)
    while place < len(png):
        (length,) = struct.unpack(">I", png[place : place + 4])
        name, body = png[place + 4 : place + 8], png[place + 8 : place + 8 + length]
        if name == b"IHDR":
            size = struct.unpack(">II", body[:8])
        if name == b"IDAT":
            data += body
        place += 12 + length
    width, height = size
    rows = np.frombuffer(zlib.decompress(data), dtype=np.uint8).reshape(height, 1 + 3 * width)[:, 1:]
    return np.cumsum(rows, axis=0, dtype=np.uint8).reshape(height, width, 3)


def test_text_is_letters_of_a_font() -> None:
    """A wider letter takes more ink than a point, and every letter some."""
    ink = []
    for letter in "W.a7":
        drawn = draw_labels(np.full((40, 40, 3), 200, dtype=np.uint8), [(letter, 20, 20)])
        ink.append(int((drawn.max(axis=2) < 128).sum()))
    assert min(ink) > 0
    assert ink[0] > ink[1]


def test_text_stays_inside_the_image() -> None:
    image = np.zeros((40, 80, 3), dtype=np.uint8)
    drawn = draw_labels(image, [("w1-a", 79, 39)])
    white = np.argwhere((drawn == 255).all(axis=2))
    assert len(white)
    assert white.max(axis=0)[0] >= 30  # near its pixel, as far as the border lets it
    assert draw_labels(image, [("a text far too long for it", 40, 20)]).shape == image.shape


def test_a_line_ends_at_the_border() -> None:
    image = np.zeros((20, 20, 3), dtype=np.uint8)
    draw_line(image, np.array([-30.0, 10.0]), np.array([50.0, 10.0]), (255, 0, 0))
    assert set(np.flatnonzero(image[:, :, 0].any(axis=1))) == {10, 11}


def test_a_crank_is_drawn_from_two_sides_with_axis_journals_pins_and_faces() -> None:
    solid, true = make_crank([0], Shape(segments=24), tilted(0.7, (9.0, 8.0, 7.0)))
    faces = [face for face in find_faces(solid.mesh, true) if face.web is not None]
    marked = pixels(crank_picture(solid.mesh, true, faces, 600, 400))
    plain = pixels(crank_picture(solid.mesh, true, [], 600, 400))
    assert marked.shape == (400, 600, 3)
    assert (marked[0, 0] == 255).all()  # the ground
    axis = (marked == (30, 60, 200)).all(axis=2)
    assert axis[:, :300].any()
    assert axis[:, 300:].any()
    assert (marked != plain).any(axis=2).mean() > 0.05  # faces in colour
    ink = (marked == (20, 20, 20)).all(axis=2)
    assert ink.sum() > (plain == (20, 20, 20)).all(axis=2).sum()  # their labels


def test_the_same_crank_gives_the_same_bytes() -> None:
    solid, true = make_crank([0, 180], Shape(segments=12))
    assert crank_picture(solid.mesh, true, [], 300, 200) == crank_picture(solid.mesh, true, [], 300, 200)
