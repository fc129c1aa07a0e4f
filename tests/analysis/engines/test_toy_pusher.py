"""A pusher and a parameter that drakesep does not know, added through tables alone.

Nothing of drakesep is patched but the registry of pushers, which is made for it.
"""

import dataclasses
import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pandas as pd
import pytest
from ruamel.yaml import YAML
from separations import coaxial, generic_pair
from toy_pushers import Strut, StrutLaw

from drakesep.analysis.engines.jax.batch import Batch
from drakesep.analysis.metrics.of_run import metrics_of_run
from drakesep.case_file.reader import builtin_cases, load_case
from drakesep.studies.simulate import simulate
from drakesep.systems.equations.pushers import PushLaw
from drakesep.systems.equations.springs import PUSHERS, PusherKind, TimedSpringLaw
from drakesep.systems.model.integration import Integration
from drakesep.systems.model.parameter_table import (
    POSITIVE,
    ParameterTable,
    Range,
    scalar,
)
from drakesep.systems.model.parameters import parameters, with_values
from drakesep.systems.model.pushers import TILTS
from drakesep.systems.model.separation import Body
from drakesep.systems.model.springs import Spring
from drakesep.systems.simulation.simulation import Simulation
from drakesep.units import unit_of, with_unit


_BURN = 0.15
"""Time for which a jet pushes, s: of its design."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Jet:
    """Pushes with a constant force for a time that does not vary."""

    name: str
    force_max: float
    axis_A: tuple[float, float, float] = (1.0, 0.0, 0.0)
    tilt_y: float = 0.0
    tilt_z: float = 0.0

    PARAMETERS: ClassVar[ParameterTable] = ParameterTable(
        scalar("force_max", "force", POSITIVE), *TILTS
    )
    duration: ClassVar[float] = _BURN

    def __post_init__(self) -> None:
        self.PARAMETERS.check(f"{self.name}: ", self)


@dataclass(frozen=True)
class JetLaw(PushLaw):
    by_time: ClassVar[bool] = True

    def end(self, p, ops):
        return _BURN

    def force(self, p, at, speed, passed, ops):
        return p.force_max

    def frequency(self, p, count, lightness, ops):
        return 1.0 / _BURN


@dataclass(frozen=True, slots=True, kw_only=True)
class WornSpring(Spring):
    """A spring with one more parameter, and one that nothing reads."""

    wear: float = 0.0
    paint: float = 1.0

    PARAMETERS: ClassVar[ParameterTable] = ParameterTable(
        *Spring.PARAMETERS,
        scalar("wear", "factor", Range(low=0.0, high=1.0, closed=True)),
        scalar("paint", "mass", POSITIVE),
    )


@dataclass(frozen=True)
class WornSpringLaw(TimedSpringLaw):
    def force(self, p, at, speed, passed, ops):
        return (1.0 - p.wear) * super().force(p, at, speed, passed, ops)


@pytest.fixture
def toys(monkeypatch):
    monkeypatch.setitem(PUSHERS, "toy", PusherKind(Strut, StrutLaw))
    monkeypatch.setitem(PUSHERS, "jet", PusherKind(Jet, JetLaw))
    monkeypatch.setitem(PUSHERS, "worn", PusherKind(WornSpring, WornSpringLaw))


def pushed_by(make):
    """The coaxial pair with other pushers, and its reduced mass."""
    pair = coaxial(generic_pair())
    attachments = tuple(
        dataclasses.replace(a, spring=make(a.spring)) for a in pair.attachments
    )
    lower, upper = (body.mass for body in pair.bodies)
    mass = lower * upper / (lower + upper)
    return dataclasses.replace(pair, attachments=attachments), mass


def worn_pair():
    return pushed_by(
        lambda s: WornSpring(
            name=s.name,
            force_max=s.force_max,
            stroke=s.stroke,
            design_mass=s.design_mass,
            wear=0.2,
        )
    )


def speeds(separation, names, rows):
    """Largest longitudinal speed of each row, of both engines, m/s."""
    simulation = Simulation(separation, Integration(accuracy=1e-10))
    metric, none = "longitudinal_speed_max", (math.inf,) * 3
    drake = [
        metrics_of_run(simulation.run(dict(zip(names, row, strict=True))), none)[metric]
        for row in rows
    ]
    result = Batch(separation, names).run(rows)
    assert not result.failures
    return np.array(drake), result.metrics[metric].to_numpy()


def test_toy_pusher_in_both_engines(toys):
    """Its work is (F - drag) stroke: v = sqrt(2 E / mu)."""
    separation, mass = pushed_by(
        lambda s: Strut(name=s.name, force_max=600.0, stroke=0.1, seal_drag=50.0)
    )
    names = ["spring_1.seal_drag", "spring_1.stroke"]
    rows = np.array([[50.0, 0.1], [20.0, 0.12]])
    energy = (600.0 - rows[:, 0]) * rows[:, 1] + 3 * 550.0 * 0.1
    drake, batch = speeds(separation, names, rows)
    # Both engines promise 1e-8; the strokes of the second row end apart.
    expected = math.sqrt(2 * energy[0] / mass)
    assert [drake[0], batch[0]] == pytest.approx([expected] * 2, rel=1e-8)
    assert batch == pytest.approx(drake, rel=1e-8)
    assert batch[1] > batch[0]


def test_pusher_for_a_time_in_both_engines(toys):
    """Its impulse is F t: v = 4 F t / mu."""
    separation, mass = pushed_by(lambda s: Jet(name=s.name, force_max=900.0))
    rows = np.array([[900.0], [1200.0]])
    impulse = (3.0 * 900.0 + rows[:, 0]) * _BURN
    drake, batch = speeds(separation, ["spring_1.force_max"], rows)
    # Both engines promise 1e-8; the second row turns, and so pushes less along x.
    assert [drake[0], batch[0]] == pytest.approx([impulse[0] / mass] * 2, rel=1e-8)
    assert batch == pytest.approx(drake, rel=1e-8)


def test_toy_parameter_in_both_engines(toys):
    """A share of the impulse F_max / w of Eq. 5 is lost, of each of four springs."""
    separation, mass = worn_pair()
    spring = separation.springs[0]
    names = [f"{s.name}.wear" for s in separation.springs]
    rows = np.array([[0.2] * 4, [0.5] * 4])
    whole = math.sqrt(spring.force_max * spring.design_mass * spring.stroke)
    impulse = 4.0 * (1.0 - rows[:, 0]) * whole
    for got in speeds(separation, names, rows):
        assert got == pytest.approx(impulse / mass, rel=1e-8)  # as both promise


def test_toy_parameter_has_its_range(toys):
    separation, _ = worn_pair()
    with pytest.raises(ValueError, match=r"spring_1: wear must be .*, got 1.5"):
        with_values(separation, {"spring_1.wear": 1.5})
    batch = Batch(separation, ["spring_1.wear"])
    assert "wear must be" in batch.run([[1.5]]).failures[0]


def test_a_parameter_that_no_equation_reads_is_refused_where_it_is_named(toys):
    separation, _ = worn_pair()
    message = r"spring_2\.paint must be a parameter that .* reads, got one that it does"
    assert parameters(separation)["spring_2.paint"] == 1.0
    with pytest.raises(ValueError, match=message):
        Batch(separation, ["spring_2.wear", "spring_2.paint"])
    with pytest.raises(ValueError, match=message):
        Simulation(separation).run({"spring_2.wear": 0.1, "spring_2.paint": 2.0})


@dataclass(frozen=True, slots=True, kw_only=True)
class PaintedBody(Body):
    paint: float = 1.0
    PARAMETERS: ClassVar[ParameterTable] = ParameterTable(
        *Body.PARAMETERS, scalar("paint", "mass", POSITIVE)
    )


def test_a_bodys_parameter_that_no_equation_reads_is_refused():
    pair = generic_pair()
    bodies = tuple(
        PaintedBody(**{f.name: getattr(body, f.name) for f in dataclasses.fields(body)})
        for body in pair.bodies
    )
    separation = dataclasses.replace(pair, bodies=bodies)
    for fly in (
        lambda: Batch(separation, ["upper.paint"]),
        lambda: Simulation(separation).run({"upper.paint": 2.0}),
    ):
        with pytest.raises(ValueError, match=r"upper\.paint must be a parameter that"):
            fly()


def test_toys_in_a_case_file_and_in_a_table(toys, tmp_path):
    data = YAML(typ="safe").load(builtin_cases()["vega"])
    attachments = [data["attachments"][f"attachment_{i}"] for i in (1, 2, 3, 4)]
    for i, attachment in enumerate(attachments, 1):
        attachment["spring"] = {
            "name": f"spring_{i}",
            "law": "toy",
            "force_max_N": 700,
            "stroke_mm": 121,
            "seal_drag_N": 15,
        }
    attachments[3]["spring"] = {
        "name": "spring_4",
        "law": "worn",
        "force_max_N": 1485,
        "stroke_mm": 121,
        "design_mass_kg": 133.6,
        "wear": 0.1,
    }
    data["dispersions"] = {"spring_1.seal_drag_N": 5, "spring_1.stroke_mm": 1}
    del data["published"]
    path = tmp_path / "toy.yaml"
    with path.open("w") as file:
        YAML(typ="safe").dump(data, file)
    case = load_case(path)
    assert case.separation.springs[0] == Strut(
        name="spring_1", force_max=700.0, stroke=0.121, seal_drag=15.0
    )
    assert case.separation.springs[3].wear == 0.1
    assert case.values_in_si({"spring_4.wear": 0.3}) == {"spring_4.wear": 0.3}
    simulate(path).save(tmp_path / "out")
    summary = pd.read_csv(tmp_path / "out" / "summary.csv")
    assert summary["spring_1.seal_drag_N"].tolist() == [15.0]
    assert summary["spring_1.stroke_mm"].tolist() == pytest.approx([121.0])

    attachments[0]["spring"]["wear"] = 0.1
    with path.open("w") as file:
        YAML(typ="safe").dump(data, file)
    with pytest.raises(ValueError, match=r"spring: wear: law: toy has none"):
        load_case(path)


def test_toys_have_units(toys):
    assert with_unit("spring_1.seal_drag") == "spring_1.seal_drag_N"
    assert with_unit("spring_1.wear") == "spring_1.wear"
    assert unit_of("spring_1.paint").symbol == "kg"
