"""Parts that stand elsewhere, measured by what was made of them where they stood."""

import dataclasses
import math

import numpy as np
import pytest
import trimesh
from flights import run_of, straight, trajectory
from hypothesis import given, settings
from hypothesis import strategies as st

from drakesep.analysis.clearance.objective import LowestClearance
from drakesep.analysis.clearance.of_pair import ACCURACY
from drakesep.analysis.clearance.of_run import ClearanceAnalysis
from drakesep.systems.checks import InputError
from drakesep.systems.model.parameters import with_values
from drakesep.systems.model.parts import Box, Capsule, Mesh, Part, Sphere
from drakesep.systems.model.recontact import Recontact


TIME = np.linspace(0.0, 1.0, 41)
NO_LIMITS = (math.inf,) * 3
ROCK = Part(name="rock", shape=Sphere(radius=0.2))
BALL = Part(name="payload_ball", shape=Sphere(radius=0.1))
SOLVER = 1e-5
"""Between shapes that are no spheres, m: each distance is taken for certain where it is
within 5e-6 of what a plane between them proves."""
EXACT = 1e-6
"""Spheres are measured to round-off; their smallest distance is found to 1e-6 s, at
which it differs from the true one to second order."""


def moved(run, **values):
    """The same motion with parts elsewhere."""
    named = {name.replace("__", "."): value for name, value in values.items()}
    return dataclasses.replace(run, separation=with_values(run.separation, named))


def fly_by():
    """B passes A's origin at 0.5 m along y: 0.2 m between the balls."""
    return run_of(straight(TIME, (-0.8, 0.5, 0.0), (2.0, 0.0, 0.0)), [ROCK], [BALL])


@given(d=st.floats(-0.4, 0.15))
def test_what_is_moved_by_d_is_d_nearer(d):
    run = fly_by()
    analysis = ClearanceAnalysis(run.separation)
    for other in (
        moved(run, rock__position_y=d),
        moved(run, payload_ball__position_y=-d),
    ):
        [found] = analysis.of(other)
        assert found.minimum == pytest.approx(0.2 - d, abs=EXACT)
    # Both alike: nothing changes.
    [same] = analysis.of(moved(run, rock__position_y=d, payload_ball__position_y=d))
    assert same.minimum == pytest.approx(0.2, abs=EXACT)


MAST = Part(
    name="mast",
    shape=Box(size=(0.3, 0.1, 0.2)),
    p_BoGo_B=(0.1, -0.2, 0.3),
    rpy_BG=(0.3, -0.2, 0.5),
)
ANTENNA = Part(
    name="antenna",
    shape=Capsule(radius=0.05, length=0.4),
    p_BoGo_B=(-0.2, 0.1, 0.1),
    rpy_BG=(0.1, 0.7, -0.3),
)
STILL = Part(name="still", shape=Sphere(radius=0.1), p_BoGo_B=(0.0, 0.1, -0.4))
PLACES = [
    f"{part}.{quantity}"
    for part in ("mast", "antenna")
    for quantity in (
        *(f"position_{axis}" for axis in "xyz"),
        *(f"attitude_{axis}" for axis in ("roll", "pitch", "yaw")),
    )
]


def tumbling():
    p = np.stack([0.6 + TIME, 0.4 - 0.5 * TIME, 0.2 * TIME], axis=1)
    v = np.tile([1.0, -0.5, 0.2], (len(TIME), 1))
    motion = trajectory(
        TIME, p, v, angle=0.9 * TIME, rate=np.full(len(TIME), 0.9), axis=(0.6, 0.0, 0.8)
    )
    return run_of(motion, [MAST, STILL], [ANTENNA])


RUN = tumbling()
ANALYSIS = ClearanceAnalysis(RUN.separation)


@settings(max_examples=20, deadline=None)
@given(shift=st.lists(st.floats(-0.1, 0.1), min_size=12, max_size=12))
def test_as_parts_that_were_made_where_they_are(shift):
    """Another description, cut into pieces anew, says the same."""
    nominal = {
        name: [*MAST.p_BoGo_B, *MAST.rpy_BG, *ANTENNA.p_BoGo_B, *ANTENNA.rpy_BG][i]
        for i, name in enumerate(PLACES)
    }
    values = {name: nominal[name] + shift[i] for i, name in enumerate(PLACES)}
    run = dataclasses.replace(RUN, separation=with_values(RUN.separation, values))
    anew = ClearanceAnalysis(run.separation)
    times = TIME[::8]
    got, expected = (a.at_times(run, times) for a in (ANALYSIS, anew))
    assert got == pytest.approx(expected, abs=SOLVER)
    for one, other in zip(ANALYSIS.of(run), anew.of(run), strict=True):
        assert (one.first, one.second) == (other.first, other.second)
        assert one.minimum == pytest.approx(other.minimum, abs=ACCURACY)


def test_nearest_points_and_normal_are_in_the_bodies():
    """They are where the other part of that description has them."""
    values = {"mast.attitude_yaw": 1.0, "mast.position_z": 0.2, "antenna.position_x": 0}
    run = dataclasses.replace(RUN, separation=with_values(RUN.separation, values))
    anew = ClearanceAnalysis(run.separation)
    for mine, theirs in zip(
        ANALYSIS.moments(run, [0.0, 0.5]), anew.moments(run, [0.0, 0.5]), strict=True
    ):
        for one, other in zip(mine, theirs, strict=True):
            assert one.names == other.names
            for got, expected in zip(one.nearest, other.nearest, strict=True):
                # A point of an edge is found as well as its distance's root.
                assert got == pytest.approx(expected, abs=2e-3)


def test_slope_is_that_of_the_points_as_the_parts_move():
    run = fly_by()
    objective = LowestClearance(run.separation)
    about = objective.about(run, NO_LIMITS)
    change = 1e-3
    for name, sign in (("rock__position_y", 1.0), ("payload_ball__position_y", -1.0)):
        near = about.near(moved(run, **{name: change}))
        assert near - about.value == pytest.approx(sign * change, abs=1e-5 * change)
    # Across the normal nothing changes, to first order.
    near = about.near(moved(run, rock__position_z=change))
    assert near == pytest.approx(about.value, abs=1e-12)
    around = [
        moved(run, rock__position_y=change),
        moved(run, payload_ball__position_y=change),
        moved(run, rock__position_z=change),
    ]
    values, changes = objective.linearised_parts(run, around)
    nearest = values[0].argmax()
    # Within 1/24 s of the nearest: the normal is turned by 0.16.
    assert changes[0, nearest] == pytest.approx([change, -change, 0.0], rel=0.02)


def test_overlap_while_mated_is_a_mistake_only_where_it_is_nominal():
    """Elsewhere it is what may happen: a contact from the beginning."""
    motion = straight(TIME, (0.4, 0.0, 0.0), (2.0, 0.0, 0.0))
    run = run_of(motion, [ROCK], [BALL])
    analysis = ClearanceAnalysis(run.separation)
    nearer = moved(run, rock__position_x=0.2)
    [found] = analysis.of(nearer)
    assert found.minimum == 0.0
    assert found.contact is not None
    assert found.time == 0.0
    assert LowestClearance(run.separation)(nearer) == 0.0
    with pytest.raises(InputError, match="must be apart while mated"):
        ClearanceAnalysis(nearer.separation).of(nearer)


def test_a_part_moved_inside_a_mesh_touches_it(tmp_path):
    """Whose surface is farther away than any limit: 0.25 m."""
    file = tmp_path / "tank.obj"
    trimesh.creation.box((0.8, 0.8, 0.8)).export(file)
    tank = Part(name="tank", shape=Mesh(file=file))
    antenna = Part(name="antenna", shape=Sphere(radius=0.05))
    run = run_of(straight(TIME, (3.0, 0.0, 0.0), (0.1, 0.0, 0.0)), [tank], [antenna])
    analysis = ClearanceAnalysis(run.separation)
    inside = moved(run, antenna__position_x=-2.9)
    [found] = analysis.of(inside)
    assert (found.minimum, found.time) == (0.0, 0.0)
    assert found.contact is not None
    assert analysis.smallest(inside) == found
    [outside] = analysis.of(moved(run, antenna__position_x=-1.0))
    assert outside.minimum == pytest.approx(2.0 - 0.4 - 0.05, abs=SOLVER)


def test_what_pushes_must_stay_where_it_is():
    separation = dataclasses.replace(
        fly_by().separation,
        recontact=Recontact(stiffness=1e5, dissipation=0.1, friction=0.0),
    )
    with pytest.raises(InputError, match=r"rock.position_x: must stay .* a recontact"):
        with_values(separation, {"rock.position_x": 0.1})
    assert with_values(separation, {"upper.mass": 1201.0}).recontact is not None
