"""Master and link rods against an own multibody system: constraints by Newton, forces by balance."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import autobalance as ab
from autobalance.errors import JobError
from autobalance.running_gear.articulated import LinkCrank
from autobalance.running_gear.loads import loads
from autobalance.running_gear.slider_crank import SliderCrank
from autobalance.running_gear.whole_engine import CrankUnbalance, Cylinder, Engine, first_order_counterweight
from tests.generated import preset_crank
from tests.near import near

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
R, L, RHO, LINK = 50.0, 210.0, 42.0, 165.0
N_PER = 1e-6


def radial(count: int, offset: float = 0.0, skew: float = 0.0) -> Engine:
    """Return a radial whose first cylinder has the master rod; knuckles at the banks' angles plus a skew."""
    master = SliderCrank(R, L, offset)
    cylinders = [Cylinder(master, 900.0, 1300.0, 0.3, 0.2, 5.0)]
    for number in range(1, count):
        bank = 0.2 + 2.0 * math.pi * number / count
        train = LinkCrank(R, LINK, offset, master, 0.2 - bank, RHO, bank - 0.2 + skew * number)
        cylinders.append(Cylinder(train, 250.0 + 10.0 * number, 1100.0, 0.3, bank, 5.0, master=0))
    return Engine(tuple(cylinders))


class Multibody:
    """Positions by Newton's method on the constraints, accelerations from their second derivatives."""

    def __init__(self, engine: Engine, angle: float, speed: float, gas: Array) -> None:
        self.engine, self.gas = engine, gas
        first = engine.cylinders[0]
        self.banks = np.exp(1j * np.array([each.bank_rad for each in engine.cylinders]))
        turned = R * np.exp(1j * (angle + first.throw_angle_rad))
        self.c = np.array([turned, 1j * speed * turned, -(speed**2) * turned])
        self.w, self.k = self._positions()

    def _positions(self) -> tuple[Complex, Complex]:
        """Return wrist pins and knuckles (cylinders, 3): place, velocity, acceleration."""
        wrists, knuckles = [], []
        master = self.engine.cylinders[0].slider_crank
        w = self._piston(self.c, L, self.banks[0], master.offset_mm)
        for cylinder, bank in zip(self.engine.cylinders, self.banks, strict=True):
            train = cylinder.slider_crank
            k = self.c
            if isinstance(train, LinkCrank):  # fixed on the master rod: the same linear map at every level
                k = self.c + RHO / L * np.exp(1j * train.knuckle_rad) * (w - self.c)
            knuckles.append(k)
            wrists.append(self._piston(k, train.rod_length_mm, bank, train.offset_mm))
        return np.array(wrists), np.array(knuckles)

    @staticmethod
    def _piston(pin: Complex, length: float, bank: complex, offset: float) -> Complex:
        """Solve |w − p|² = l² on the line w = (x + i e) b for x, then for its two derivatives."""
        x = length + R
        for _ in range(60):
            rod = (x + 1j * offset) * bank - pin[0]
            x -= (abs(rod) ** 2 - length**2) / (2.0 * (rod.conjugate() * bank).real)
        rod = (x + 1j * offset) * bank - pin[0]
        along = (rod.conjugate() * bank).real
        speed = (rod.conjugate() * pin[1]).real / along
        relative = speed * bank - pin[1]
        second = ((rod.conjugate() * pin[2]).real - abs(relative) ** 2) / along
        return np.array([(x + 1j * offset) * bank, speed * bank, second * bank])

    def forces(self) -> tuple[complex, Array]:
        """Return the whole load on the crankpin and the walls' forces along bank + 90° [N]."""
        walls = np.zeros(len(self.banks))
        on_links = moment = 0.0 + 0.0j
        for n, cylinder in list(enumerate(self.engine.cylinders))[1:]:
            bank, along = self.banks[n], self.w[n] - self.k[n]
            u = along[0] / abs(along[0])
            push = cylinder.reciprocating_g * N_PER * self.w[n][2] + self.gas[n] * bank
            # push = S u + N i b: the rod's axial force and the wall's
            system = np.array([[u.real, (1j * bank).real], [u.imag, (1j * bank).imag]])
            axial, wall = np.linalg.solve(system, [push.real, push.imag])
            walls[n] = -wall
            pull = -axial * u - cylinder.rotating_g * N_PER * self.k[n][2]
            on_links += pull
            arm = self.k[n][0] - self.c[0]
            moment += (arm.conjugate() * pull).imag
        first = self.engine.cylinders[0]
        bank, arm = self.banks[0], self.w[0][0] - self.c[0]
        push = first.reciprocating_g * N_PER * self.w[0][2] + self.gas[0] * bank
        # piston on rod P = −push + N i b; (w − c) × P + the links' moment = 0
        lever = (arm.conjugate() * (1j * bank)).imag
        wall = ((arm.conjugate() * push).imag - moment.real) / lever
        walls[0] = -wall
        pin = -push + wall * 1j * bank + on_links - first.rotating_g * N_PER * self.c[2]
        return complex(pin), walls


@pytest.mark.parametrize(
    ("count", "offset", "skew"), [(3, 0.0, 0.0), (5, 4.0, 0.03), (7, 0.0, 0.05), (9, -3.0, 0.0)]
)
def test_radials_against_multibody(count: int, offset: float, skew: float) -> None:
    engine = radial(count, offset, skew)
    speed = 260.0
    angles = np.linspace(0.0, 2.0 * math.pi, 23, endpoint=False)
    gas = np.random.default_rng(count).uniform(0.0, 2e4, (count, len(angles)))
    found = loads(engine, (0.0, 10.0), speed, angles, gas_n=gas)
    shaking = engine.force_n(angles, speed)
    for n, angle in enumerate(angles):
        body = Multibody(engine, float(angle), speed, gas[:, n])
        pin, walls = body.forces()
        own = found.crankpin_n[:, n].sum(axis=0)
        assert complex(*own) == pytest.approx(pin, rel=1e-8)
        assert near(found.wall_n[:, n], walls, rel=1e-8, within=1e-5)
        assert near(found.main_n[:, n].sum(axis=0), own, rel=1e-9)
        torque = (body.c[0].conjugate() * pin).imag * 1e-3
        assert near(found.gas_torque_n_m[n] - found.torque_n_m[n], torque, rel=1e-8, within=1e-6)
        momentum = sum(
            each.reciprocating_g * w[2] + each.rotating_g * k[2]
            for each, w, k in zip(engine.cylinders, body.w, body.k, strict=True)
        )
        assert complex(*shaking[n]) == pytest.approx(-complex(momentum) * N_PER, rel=1e-8)
    # all orders together are the force: to the 40th they are, to the last digits
    total = np.zeros((len(angles), 2), dtype=complex)
    for order in engine.orders(speed, 40):
        total += np.exp(1j * order.order * angles)[:, None] * order.force_n
    mean = engine.force_n(np.linspace(0, 2 * math.pi, 720, endpoint=False), speed).mean(axis=0)
    assert near(total.real + mean, shaking, rel=1e-6, within=1e-6 * abs(shaking).max())


def test_strokes_and_dead_centres_differ_and_are_where_the_piston_stands_still() -> None:
    for cylinder in radial(5, skew=0.04).cylinders[1:]:
        train = cylinder.slider_crank
        angle = np.linspace(0.0, 2.0 * math.pi, 200001)
        place = train.position_mm(angle)
        assert train.stroke_mm == pytest.approx(np.ptp(place), rel=1e-9)
        assert train.stroke_mm != pytest.approx(2.0 * R, rel=1e-3)
        top, bottom = train.dead_centres_rad
        assert train.position_mm(np.array(top)) >= place.max() - 1e-9
        assert train.position_mm(np.array(bottom)) <= place.min() + 1e-9


def test_a_knuckle_at_the_crankpin_is_a_plain_rod() -> None:
    master = SliderCrank(R, L)
    link = LinkCrank(R, LINK, 0.0, master, -1.0, 0.0, 0.7)
    plain = SliderCrank(R, LINK)
    angle = np.linspace(0.0, 6.0, 50)
    for name in ("x_mm", "dx_mm", "ddx_mm", "rod_sine", "dtilt", "ddtilt"):
        assert getattr(link.motion(angle), name) == pytest.approx(
            getattr(plain.motion(angle), name), abs=1e-10
        )
    assert link.stroke_mm == pytest.approx(plain.stroke_mm, rel=1e-12)
    assert link.harmonics(8)[1:3] == pytest.approx(plain.harmonics(8)[1:3], abs=1e-9)


def test_the_first_order_of_a_radial_asks_for_half_of_what_reciprocates() -> None:
    """With long rods and small knuckles: m_rot r + n/2 m_rec r, opposite the crankpin, nothing backward."""
    far = SliderCrank(R, 1e6)
    cylinders = [Cylinder(far, 900.0, 1000.0, 0.3)]
    for number in range(1, 7):
        bank = 2.0 * math.pi * number / 7
        train = LinkCrank(R, 1e6, 0.0, far, -bank, 1e-3, bank)
        cylinders.append(Cylinder(train, 200.0, 1000.0, 0.3, bank, master=0))
    wanted = first_order_counterweight(Engine(tuple(cylinders)))
    assert wanted.product_g_mm == pytest.approx(R * (900.0 + 6 * 200.0 + 3.5 * 1000.0), rel=1e-4)
    assert wanted.angle_deg == pytest.approx(180.0 + math.degrees(0.3), rel=1e-4)
    assert wanted.backward_g_mm < 1.0
    # put on, nothing turns forward any more
    engine = radial(9, skew=0.02)
    wanted = first_order_counterweight(engine)
    direction = math.radians(wanted.angle_deg)
    own = CrankUnbalance(wanted.product_g_mm * np.array([math.cos(direction), math.sin(direction)]), 0.0)
    first = replace(engine, crank=(own,)).orders(100.0, 1)[-1]
    assert first.circles_n[0] < 1e-9 * first.circles_n[1]


# --- by the door --------------------------------------------------------------------------------------------


def job(**changes: Any) -> dict[str, Any]:
    links = [
        {
            "cylinder": n + 1,
            "bank_deg": 72.0 * n,
            "rod_length_mm": 110.0,
            "knuckle_radius_mm": 30.0,
            "knuckle_angle_deg": 72.0 * n,
        }
        for n in range(1, 5)
    ]
    return {
        "engine": {
            "rod_length_mm": 140,
            "rotating_g": {"big_end": 500.0},
            "reciprocating_g": {"piston": 400.0},
            "layout": {"kind": "articulated", "bank_deg": 0.0},
            "throw": [{"number": 1, "link": links, **changes.pop("throw", {})}],
            **changes.pop("engine", {}),
        },
        "balance": {"factor": 0.5, "grade": 6.3, "speed_rpm": 3000},
        "correction": {"method": "drill"},
        "cycle": {"bore_mm": 80, "compression_ratio": 7, "heat_J": 800, "firing_order": [1, 3, 5, 2, 4]},
        **changes,
    }


@pytest.fixture(scope="module")
def single() -> ab.Crank:
    return preset_crank("single", 48)


def test_a_radial_by_the_door(single: ab.Crank) -> None:
    made = ab.Job.from_dict(job())
    report = ab.forces(made, crank=single).report
    rows = report["cylinders"]
    assert [each["number"] for each in rows] == [1, 2, 3, 4, 5]
    assert len({round(each["stroke_mm"], 3) for each in rows}) == 3  # alike by pairs about the master
    assert rows[0]["top_dead_centre_deg"] == pytest.approx(0.0, abs=1e-9)
    assert rows[1]["top_dead_centre_deg"] + rows[4]["top_dead_centre_deg"] == pytest.approx(360.0)
    assert report["states"][0]["force"]["orders"][-1]["order"] == 12.0
    cycle = ab.cycle(made, crank=single)
    assert cycle.report["energy_error"] < 1e-9
    assert [each["stroke_mm"] for each in cycle.report["cylinders"]] == [each["stroke_mm"] for each in rows]
    firing = cycle.report["firing_deg"]
    assert sorted(firing) == [firing[n] for n in (0, 2, 4, 1, 3)]
    # forces on the engine and momentum: mains, walls and gas on heads balance the moving masses
    mirrored = ab.forces(ab.Job.from_dict(job(engine={"turns": "cw"})), crank=single).report
    assert mirrored["first_order_counterweight"]["product_g_mm"] > 0.0


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"engine": {"layout": {}}}, 'expected engine.layout.kind = "articulated" beside it'),
        ({"throw": {"rods": 4}}, "rods is 4; expected 5, a master and 4 links"),
        ({"throw": {"bank_deg": [0, 72]}}, "has 2 angles; expected one, the master's"),
    ],
)
def test_bad_input_is_one_line(single: ab.Crank, change: dict[str, Any], words: str) -> None:
    with pytest.raises(JobError, match=words) as refused:
        ab.forces(ab.Job.from_dict(job(**change)), crank=single)
    assert "\n" not in str(refused.value)
