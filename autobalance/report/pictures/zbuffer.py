"""Drawing of triangles, lines and letters into a picture."""

from __future__ import annotations

import math
import struct
import zlib
from collections.abc import Sequence
from importlib import resources
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from autobalance.types import Array, Indices
from autobalance.value_classes import dataclass

# Drawing of triangles into a picture: a z-buffer on arrays, and PNG. No graphics library, no screen.


Image = NDArray[np.uint8]
"""Rows from the top, pixels from the left, red green blue (h, w, 3)."""

WHITE = (1.0, 1.0, 1.0)
SUPERSAMPLE = 2
"""Samples a pixel, each way: edges come out smooth."""
MARGIN = 0.06
"""Space around the part, as a share of the picture."""
CREASE = math.cos(math.radians(25.0))
"""Cosine of the angle between the surfaces of neighbouring samples; sharper ones get a line between them."""
SAME_DIRECTION = 2.0**19
"""Cells per unit of a normal, within which directions count as the same."""
LINE_SHADE = 0.55
"""Brightness of a line against the surface that it lies on."""
OVERLAP = 1e-6
"""Triangles claim samples this far beyond their sides [samples]: rounding leaves no gap between two."""
ROWS_AT_ONCE = 100_000
"""Rows of triangles processed together: their data stay in the processor's cache."""
SAMPLES_AT_ONCE = 100_000
"""Samples of these rows processed together."""
BAND = 64
"""Rows of the picture's samples processed together; whole pixels."""
EMPTY_SAMPLE = np.uint64(0xFFFFFFFFFFFFFFFF)
Surface = tuple[Array, Indices, Array]
"""Vertices (n, 3), triangles (m, 3), and a colour for each triangle or one for all (3,)."""


@dataclass(frozen=True, eq=False)
class Camera:
    """A parallel projection.

    Attributes
    ----------
    looks : (3,) float
        Direction of sight, from the eye into the picture.
    up : (3,) float
        What points up in the picture; not along ``looks``.
    fit : (k, 3) float or None
        Points that must lie inside the picture, so that two parts can share one view; None: the part itself.
    """

    looks: ArrayLike = (-1.0, -0.8, -0.6)
    up: ArrayLike = (1.0, 0.0, 0.0)
    fit: Array | None = None

    @property
    def axes(self) -> Array:
        """Rows right, up and towards the eye (3, 3), of unit length."""
        back = -np.asarray(self.looks, dtype=np.float64)
        back /= np.linalg.norm(back)
        right = np.cross(np.asarray(self.up, dtype=np.float64), back)
        right /= np.linalg.norm(right)
        return np.stack([right, np.cross(back, right), back])


@dataclass(frozen=True, eq=False)
class Picture:
    """A drawn part.

    ``image`` (h, w, 3) is uint8. ``triangle`` (h, w) int64 is the row of the triangle seen at each pixel, −1
    without one. ``to_pixel`` (2, 4) takes a homogeneous point to (column, row).
    """

    image: Image
    triangle: Indices
    to_pixel: Array


def render(
    vertices: Array,
    triangles: Indices,
    triangle_colours: ArrayLike,
    camera: Camera,
    width: int = 1200,
    height: int = 800,
) -> Picture:
    """Draw a closed mesh, lit from the eye's upper left, with lines along its creases.

    Parameters
    ----------
    vertices : (n, 3) float
    triangles : (m, 3) int
        Counter-clockwise seen from outside; those that look away are not drawn.
    triangle_colours : (m, 3) or (3,) float
        Red, green, blue from 0 to 1, before light.
    camera : Camera
    width, height : int
        Of the picture [pixels].

    Returns
    -------
    Picture
    """
    nothing = np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64), np.zeros((0, 3))
    part = vertices, triangles, np.asarray(triangle_colours, dtype=np.float64)
    return render_each(part, [nothing], camera, width, height)[0]


def render_each(
    part: Surface,
    coats: Sequence[Surface],
    camera: Camera,
    width: int,
    height: int,
) -> list[Picture]:
    """Draw a part several times, each time with another surface laid on it; the part is drawn only once.

    In each picture's ``triangle`` the numbers of the coat follow those of the part.
    """
    axes = camera.axes
    fit = part[0] if camera.fit is None else camera.fit
    to_fine = _placement(axes, fit, width * SUPERSAMPLE, height * SUPERSAMPLE)
    window = _window(to_fine, [part, *coats], width, height)
    wide, high = ((each.stop - each.start) * SUPERSAMPLE for each in window)
    to_window = to_fine.copy()
    to_window[:2, 3] -= [each.start * SUPERSAMPLE for each in window]
    bare = np.full(wide * high, EMPTY_SAMPLE, dtype=np.uint64)
    _draw(part, to_window, bare, wide, 0)
    looks = _looks(part, axes)
    pictures = []
    for number, coat in enumerate(coats, 1):
        seen = bare.copy() if number < len(coats) else bare
        _draw(coat, to_window, seen, wide, len(part[1]))
        normals, lit = (np.concatenate(pair) for pair in zip(looks, _looks(coat, axes), strict=True))
        image = np.tile(_bytes(np.array([WHITE])).view(np.uint8)[:3], (height, width, 1))
        triangle = np.full((height, width), -1)
        inside = image[window[::-1]], triangle[window[::-1]]
        _shade(seen.reshape(high, wide), normals, lit, inside)
        pictures.append(Picture(image, triangle, to_fine[:2] / SUPERSAMPLE))
    return pictures


def _shade(
    seen: NDArray[np.uint64],
    normals: Array,
    lit: Array,
    picture: tuple[Image, Indices],
) -> None:
    """Fill a picture and its triangles from the samples seen, a band of rows after the other."""
    image, triangle = picture
    bright, dark = _bytes(np.concatenate([lit, [WHITE]])), _bytes(lit * LINE_SHADE)
    columns = np.ascontiguousarray(normals.T)
    directions = _directions(columns)
    for first in range(0, len(seen), BAND):
        above = min(first, 1)  # lines depend on the rows beside them
        which = (
            seen[first - above : first + BAND + 1].astype(np.uint32).view(np.int32)
        )  # EMPTY_SAMPLE becomes −1
        lines = _creases(which, columns, directions)
        colour = bright[which]
        colour[lines] = dark[which[lines]]
        own = slice(above, above + BAND)
        rows = slice(first // SUPERSAMPLE, (first + BAND) // SUPERSAMPLE)
        image[rows] = _halved(colour[own].view(np.uint8).reshape(*colour[own].shape, 4))
        triangle[rows] = which[own][::SUPERSAMPLE, ::SUPERSAMPLE]


def _window(to_fine: Array, surfaces: Sequence[Surface], width: int, height: int) -> tuple[slice, slice]:
    """Return the columns and rows of the picture that surfaces may reach; nothing is drawn beside them."""
    places = np.concatenate([vertices for vertices, _, _ in surfaces]) @ to_fine[:2, :3].T + to_fine[:2, 3]
    within = np.zeros(2), np.array([width, height])
    first = np.clip(np.floor(places.min(axis=0, initial=np.inf) / SUPERSAMPLE) - 1.0, *within)
    last = np.clip(np.ceil(places.max(axis=0, initial=-np.inf) / SUPERSAMPLE) + 1.0, first, within[1])
    columns, rows = (slice(int(low), int(high)) for low, high in zip(first, last, strict=True))
    return columns, rows


def _looks(surface: Surface, axes: Array) -> tuple[Array, Array]:
    """Return normals in the camera's axes and lit colours of a surface's triangles."""
    vertices, triangles, colours = surface
    normals = _normals(vertices, triangles) @ axes.T
    return normals, _lit(np.broadcast_to(colours, (len(triangles), 3)), normals)


def _bytes(colours: Array) -> NDArray[np.uint32]:
    """Return colours (k, 3) from 0 to 1 in one word each: looked up faster than three floats."""
    four = np.zeros((len(colours), 4), dtype=np.uint8)
    four[:, :3] = (np.asarray(colours) * 255.0 + 0.5).clip(0, 255)
    return four.view(np.uint32).reshape(-1)


def _halved(fine: NDArray[np.uint8]) -> Image:
    """Return the mean of the samples (h, w, 4) of each pixel."""
    columns = np.zeros((fine.shape[0] // SUPERSAMPLE, *fine.shape[1:]), dtype=np.uint16)
    for i in range(SUPERSAMPLE):
        columns += fine[i::SUPERSAMPLE]
    words = columns.view(np.uint64)[:, :, 0]  # a sample's four numbers, none of which runs over, added as one
    total = np.zeros((words.shape[0], words.shape[1] // SUPERSAMPLE), dtype=np.uint64)
    for j in range(SUPERSAMPLE):
        total += words[:, j::SUPERSAMPLE]
    sums = total.view(np.uint16).reshape(*total.shape, 4)[:, :, :3]
    mean: Image = ((sums + SUPERSAMPLE) // SUPERSAMPLE**2).astype(np.uint8)
    return mean


def _placement(axes: Array, points: Array, width: int, height: int) -> Array:
    """Return the map (3, 4) from space to column, row and depth (growing away from the eye)."""
    flat = points @ axes.T
    low, high = flat.min(axis=0), flat.max(axis=0)
    size = np.maximum(high - low, 1e-12)
    scale = (1.0 - 2.0 * MARGIN) * min(width / size[0], height / size[1])
    middle = 0.5 * (low + high)
    place = np.zeros((3, 4))
    place[:, :3] = axes * np.array([[scale], [-scale], [-scale]])
    place[:, 3] = np.array([0.5 * width, 0.5 * height, 0.0]) + np.array([-scale, scale, scale]) * middle
    return place


def _doubled_area(corners: Array) -> Array:
    """Return twice the signed area of flat triangles (m, 3, ≥ 2)."""
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    return (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])


def _draw(surface: Surface, to_fine: Array, buffer: NDArray[np.uint64], width: int, start: int) -> None:
    """Put a surface into the buffer: of each sample the upper half is the depth, the lower the triangle.

    Each triangle is cut into rows, each row is the interval of columns that its three edges leave.
    """
    vertices, triangles, _ = surface
    seen = vertices @ to_fine[:, :3].T + to_fine[:, 3]
    corners = seen[triangles]
    facing = np.flatnonzero(_doubled_area(corners) < 0.0)  # rows grow downward: outward turns negative
    corners = corners[facing]
    y = corners[:, :, 1]
    height = len(buffer) // width
    first = np.clip(np.ceil(y.min(axis=1) - 0.5 - OVERLAP), 0, height).astype(np.int64)
    last = np.clip(np.floor(y.max(axis=1) - 0.5 + OVERLAP), -1, height - 1).astype(np.int64)
    rows = np.cumsum(np.maximum(last - first + 1, 0))
    if len(rows) == 0 or rows[-1] == 0:
        return
    cuts = np.searchsorted(rows, np.arange(ROWS_AT_ONCE, rows[-1], ROWS_AT_ONCE))
    for few in np.split(np.arange(len(facing)), cuts):
        number, row = _ranges(first[few], last[few])
        _fill(corners[few], facing[few] + start, number, row, buffer, width)


def _fill(
    corners: Array, names: Indices, number: Indices, row: Indices, buffer: NDArray[np.uint64], width: int
) -> None:
    """Put the rows of some triangles into the buffer; ``number`` is the triangle of each row."""
    left, right = _spans(corners, number, row.astype(np.float64) + 0.5, width)
    meets = right >= left  # most rows of a sliver hold no sample
    number, row, left, right = number[meets], row[meets], left[meets], right[meets]
    gx, gy, g0 = _depth_plane(corners)
    across = gx.take(number)
    at_zero = gy.take(number) * (row + 0.5) + g0.take(number) + 0.5 * across
    name = names.astype(np.uint64).take(number)
    ends = np.cumsum(right - left + 1)
    cuts = np.searchsorted(ends, np.arange(SAMPLES_AT_ONCE, ends[-1] if len(ends) else 0, SAMPLES_AT_ONCE))
    for first, last in zip([0, *cuts], [*cuts, len(ends)], strict=True):
        few = slice(first, last)
        count = right[few] - left[few] + 1
        column = np.arange(int(count.sum())) + np.repeat(left[few] + count - np.cumsum(count), count)
        far = (np.repeat(across[few], count) * column + np.repeat(at_zero[few], count)).astype(np.float32)
        sample = (_ordered(far) << np.uint64(32)) | np.repeat(name[few], count)
        np.minimum.at(buffer, np.repeat(row[few] * width, count) + column, sample)


def _spans(corners: Array, number: Indices, centre: Array, width: int) -> tuple[Indices, Indices]:
    """Return the first and the last column of each row of each triangle."""
    low, high = np.full(len(number), 0.0), np.full(len(number), float(width))
    for slope, offset, side in _edges(corners):
        meets = slope.take(number)
        meets *= centre
        meets += offset.take(number)
        np.maximum(low, meets, out=low, where=(side > 0.0).take(number))
        np.minimum(high, meets, out=high, where=(side < 0.0).take(number))
    left = np.maximum(np.ceil(low - 0.5 - OVERLAP), 0.0).astype(np.int64)
    right = np.minimum(np.floor(high - 0.5 + OVERLAP), width - 1.0).astype(np.int64)
    return left, right


def _ranges(first: Indices, last: Indices) -> tuple[Indices, Indices]:
    """Return the members of integer ranges, ends included: number of the range, and value."""
    count = np.maximum(last - first + 1, 0)
    number = np.repeat(np.arange(len(first)), count)
    start = np.cumsum(count) - count
    return number, first[number] + (np.arange(len(number)) - start[number])


def _edges(corners: Array) -> list[tuple[Array, Array, Array]]:
    """Return each side's column as slope · row + offset, and on which side the triangle lies (±1, 0)."""
    sides = []
    for k in range(3):
        p, q = corners[:, k, :2], corners[:, (k + 1) % 3, :2]
        rise = q[:, 1] - p[:, 1]
        slope = (q[:, 0] - p[:, 0]) / np.where(rise == 0.0, 1.0, rise)
        sides.append((slope, p[:, 0] - slope * p[:, 1], np.sign(rise)))
    return sides


def _depth_plane(corners: Array) -> Array:
    """Return depth as gx · column + gy · row + g0 over each triangle (3, m)."""
    a = corners[:, 0]
    u, v = corners[:, 1] - a, corners[:, 2] - a
    det = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    gx = (u[:, 2] * v[:, 1] - v[:, 2] * u[:, 1]) / det
    gy = (v[:, 2] * u[:, 0] - u[:, 2] * v[:, 0]) / det
    return np.stack([gx, gy, a[:, 2] - gx * a[:, 0] - gy * a[:, 1]])


def _ordered(depth: NDArray[np.float32]) -> NDArray[np.uint64]:
    """Return floats as whole numbers of the same order."""
    bits = depth.view(np.uint32)
    return np.where(bits >> 31, ~bits, bits | np.uint32(0x80000000)).astype(np.uint64)


def _normals(vertices: Array, triangles: Indices) -> Array:
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    return normal / np.where(length == 0.0, 1.0, length)


def _lit(colours: Array, normals: Array) -> Array:
    """Return colours shaded by normals in the camera's axes: key light, fill light, some ambient light."""
    key = np.array([-0.45, 0.65, 0.62])
    fill = np.array([0.70, -0.20, 0.68])
    halfway = np.array([-0.25, 0.36, 0.90])
    light = 0.36 + 0.50 * np.clip(normals @ key, 0.0, None) + 0.34 * np.clip(normals @ fill, 0.0, None)
    gleam = 0.10 * np.clip(normals @ halfway, 0.0, 1.0) ** 24
    shaded: Array = np.clip(colours * light[:, None] + gleam[:, None], 0.0, 1.0)
    return shaded


def _creases(which: NDArray[np.int32], normals: Array, directions: Indices) -> NDArray[np.bool_]:
    """Return the samples whose right or lower neighbour shows another surface at an angle, or none.

    ``normals`` are (3, m), ``directions`` their numbers from `_directions`.
    """
    lines = np.zeros(which.shape, dtype=bool)
    facing = directions[which]
    for here, there in (
        ((slice(None), slice(None, -1)), (slice(None), slice(1, None))),
        ((slice(None, -1),), (slice(1, None),)),
    ):
        a, b = which[here], which[there]
        place = np.flatnonzero(facing[here] != facing[there])
        one, other = a.reshape(-1)[place], b.reshape(-1)[place]
        sharp = sum(axis.take(one) * axis.take(other) for axis in normals) < CREASE
        sharp |= (one < 0) | (other < 0)
        flag = np.zeros(a.size, dtype=bool)
        flag[place[sharp]] = True
        lines[here] |= flag.reshape(a.shape) & (a >= 0)
        lines[there] |= flag.reshape(a.shape) & (a < 0)
    return lines & (which >= 0)


def _directions(normals: Array) -> Indices:
    """Return a number for each unit vector (3, m), equal only for nearly equal ones; −1, for none, last.

    Most neighbouring samples show triangles of one plane: there, no angle need be looked up.
    """
    cells = ((normals + 1.0) * SAME_DIRECTION).astype(np.int64)
    return np.append((cells[0] << 42) | (cells[1] << 21) | cells[2], -1)


def png(image: Image) -> bytes:
    """Return an image (h, w, 3) uint8 as the bytes of a PNG file."""
    height, width, _ = image.shape
    rows = np.ascontiguousarray(image).reshape(height, width * 3)
    change = rows.copy()
    change[1:] -= rows[:-1]  # filter "up": flat areas become zeros
    data = np.concatenate([np.full((height, 1), 2, dtype=np.uint8), change], axis=1).tobytes()

    def chunk(name: bytes, body: bytes) -> bytes:
        return struct.pack(">I", len(body)) + name + body + struct.pack(">I", zlib.crc32(name + body))

    head = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    return (
        b"\x89PNG\r\n\x1a\n"
        + chunk(b"IHDR", head)
        + chunk(b"IDAT", zlib.compress(data, 4))
        + chunk(b"IEND", b"")
    )


# Places of labels in pictures, none over another.


Box = tuple[float, float, float, float]
"""Left, top, right, bottom [pixels]."""
RINGS = 40
PLACES_PER_RING = 16
"""Places that are tried around a mark: ``RINGS`` rings of this many."""


class PlacedLabel(NamedTuple):
    """A label: its mark, and the place of its middle."""

    mark: tuple[float, float]
    middle: tuple[float, float]


def placed(
    marks: Sequence[tuple[float, float]],
    sizes: Sequence[tuple[float, float]],
    picture: tuple[float, float],
    away: float = 0.0,
) -> list[PlacedLabel]:
    """Return places of labels: near their marks, inside the picture, none over another.

    Parameters
    ----------
    marks, sizes : sequences of (float, float)
        Column and row of each mark, width and height of each label [pixels].
    picture : (float, float)
        Width and height [pixels].
    away : float
        Smallest distance of a label's middle from its mark; 0: on it if there is room.
    """
    boxes: list[Box] = []
    places_of_labels = []
    for mark, (wide, high) in zip(marks, sizes, strict=True):
        best = mark
        for ring in range(RINGS):
            radius = away + 6.0 * ring
            turns = [
                2.0 * math.pi * k / PLACES_PER_RING - 0.25 * math.pi
                for k in range(PLACES_PER_RING if radius else 1)
            ]
            places = [(mark[0] + radius * math.cos(t), mark[1] + radius * math.sin(t)) for t in turns]
            free = [each for each in places if _is_free(_box(each, wide, high), boxes, picture)]
            if free:
                best = free[0]
                break
        boxes.append(_box(best, wide, high))
        places_of_labels.append(PlacedLabel(mark, best))
    return places_of_labels


def _box(middle: tuple[float, float], wide: float, high: float) -> Box:
    x, y = middle
    return x - 0.5 * wide, y - 0.5 * high, x + 0.5 * wide, y + 0.5 * high


def _is_free(box: Box, boxes: Sequence[Box], picture: tuple[float, float]) -> bool:
    left, top, right, bottom = box
    if left < 0.0 or top < 0.0 or right > picture[0] or bottom > picture[1]:
        return False
    return not any(left < r and l < right and top < b and t < bottom for l, t, r, b in boxes)  # noqa: E741


# Labels and lines drawn into pictures.


INK, PAPER, LEADER = (20, 20, 20), (255, 255, 255), (90, 90, 90)
SIZE, PAD = 15, 3


def draw_labels(image: Image, labels: Sequence[tuple[str, int, int]]) -> Image:
    """Return an image with texts at pixels (column, row), on a light ground, none over another.

    A line joins a text and its pixel where they are apart.
    """
    from PIL import Image as Pillow
    from PIL import ImageDraw, ImageFont

    canvas = Pillow.fromarray(image)
    pen, font = ImageDraw.Draw(canvas), ImageFont.load_default(SIZE)
    if not all(text.isascii() for text, _, _ in labels):  # Pillow's font has no µ
        with resources.as_file(resources.files("autobalance.report") / "assets" / "DejaVuSans.ttf") as path:
            font = ImageFont.truetype(str(path), SIZE)
    boxes = [pen.textbbox((0, 0), text, font, anchor="lt") for text, _, _ in labels]
    sizes = [(right + 2.0 * PAD, bottom + 2.0 * PAD) for _, _, right, bottom in boxes]
    marks = [(float(column), float(row)) for _, column, row in labels]
    places = placed(marks, sizes, canvas.size)
    for label in places:
        if label.mark != label.middle:
            pen.line((*label.mark, *label.middle), fill=LEADER, width=1)
    for (text, _, _), label, (wide, high) in zip(labels, places, sizes, strict=True):
        x, y = label.middle
        pen.rectangle((x - 0.5 * wide, y - 0.5 * high, x + 0.5 * wide, y + 0.5 * high), fill=PAPER)
        pen.text((x, y), text, INK, font, anchor="mm")
    return np.array(canvas, dtype=np.uint8)


def draw_line(image: Image, start: Array, end: Array, colour: tuple[int, int, int]) -> None:
    """Draw a dash-dotted line between two pixels (column, row), two pixels wide."""
    count = int(np.ceil(2.0 * np.hypot(*(end - start)))) + 1
    share = np.linspace(0.0, 1.0, count)
    points = start + share[:, None] * (end - start)
    run = share * np.hypot(*(end - start)) % 36.0
    points = points[(run < 20.0) | ((run > 26.0) & (run < 30.0))]
    for aside in (0, 1):
        column, row = (points + 0.5).astype(np.int64).T
        row = row + aside
        inside = (row >= 0) & (row < image.shape[0]) & (column >= 0) & (column < image.shape[1])
        image[row[inside], column[inside]] = colour
