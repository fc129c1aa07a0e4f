"""What events latch, in which order, on lanes that are not flown."""

import dataclasses
import math

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from separations import generic_pair

from drakesep.systems.batch import lobatto
from drakesep.systems.batch.equations import BatchEquations
from drakesep.systems.batch.event_kinds import (
    LiftOffs,
    LoadRows,
    ProfileCorners,
    ReleasesAfterTravel,
    ReleasesAtAngle,
    StrokeEnds,
    TimedReleases,
    TimedStrokeEnds,
)
from drakesep.systems.batch.events import Events
from drakesep.systems.equations.relative_motion import body_state
from drakesep.systems.model.joints import Joint
from drakesep.systems.model.loads import Load
from drakesep.systems.model.parameters import parameters
from drakesep.systems.model.springs import DisplacementSpring


STROKE = 0.08
CORNER = 0.25
RELEASE = 0.03


@pytest.fixture(autouse=True)
def double_precision():
    with jax.enable_x64(True):
        yield


def retro() -> Load:
    """A load that starts at the release of the second attachment."""
    return Load(
        name="retro",
        body="lower",
        times=(0.0, 0.4),
        forces=((-80, 0, 5), (-80, 0, 5)),
        after="attachment_2",
    )


def pair(release_times=(0.0, RELEASE, RELEASE), loads=(), springs=None):
    separation = generic_pair(release_times=release_times)
    attachments = separation.attachments
    if springs is not None:
        attachments = tuple(
            dataclasses.replace(a, spring=springs(f"spring_{i + 1}"))
            for i, a in enumerate(attachments)
        )
    return dataclasses.replace(separation, attachments=attachments, loads=loads)


def by_displacement(name: str) -> DisplacementSpring:
    return DisplacementSpring(
        name=name,
        force_max=1500.0,
        stroke=STROKE,
        damping=100.0,
        profile=((0.0, 1.0), (CORNER, 0.9), (1.0, 0.2)),
    )


class Lanes:
    """Lanes of a separation at rest, whose body B is where a test puts it."""

    def __init__(self, separation, n: int = 1, **options):
        at_rest = dataclasses.replace(
            separation,
            initial=dataclasses.replace(
                separation.initial, rpy_WA=(0.0,) * 3, w_WA_A=(0.0,) * 3
            ),
        )
        equations = BatchEquations(at_rest)
        self.events = Events(equations, **options)
        self.params = equations.params(parameters(at_rest), n)
        self.x, mode = equations.start(self.params)
        self.n = n
        self.latched = self.events.start(mode)

    def moved(self, displacement, speed=0.0):
        """The states, with B moved along A's x axis; of displacements (..., n)."""
        displacement = jnp.asarray(displacement)
        shape = (*self.x.shape[:1], *displacement.shape[:-1], *self.x.shape[1:])
        between = tuple(range(1, displacement.ndim))
        x = jnp.broadcast_to(jnp.expand_dims(self.x, between), shape)
        return x.at[4, ..., 1, :].add(displacement).at[10, ..., 1, :].add(speed)

    def latch(self, t, x=None, crossed=None):
        """Latch what happens; return which lanes are fresh."""
        crossed = self.none if crossed is None else crossed
        bodies = body_state(self.x if x is None else x, 0, 7)
        t = jnp.broadcast_to(jnp.asarray(t, dtype=float), (self.n,))
        self.latched, fresh = self.events.latch(
            self.latched, crossed, t, bodies, self.params
        )
        return np.asarray(fresh)

    @property
    def none(self):
        """No crossing of any kind."""
        return tuple(jnp.zeros_like(watched) for watched in self.latched.watched)

    def all_of(self, chosen):
        """Every crossing of a kind."""
        return tuple(
            jnp.full_like(no, type(kind) is chosen)
            for kind, no in zip(self.events.crossings, self.none, strict=True)
        )

    @property
    def mode(self):
        return self.latched.mode

    @property
    def released(self):
        return np.asarray(self.mode.released)[:, 0].tolist()

    @property
    def next_known(self) -> float:
        return float(self.events.next_known(self.params, self.mode)[0])


def which(events) -> list[str]:
    return [type(event).__name__ for event in events]


def test_every_kind_in_the_order_of_the_table():
    hinge = Joint(K_F=2e5, D_F=2e3, K_T=2e5, D_T=2e3, type="revolute")
    separation = pair(springs=by_displacement)
    attachments = list(separation.attachments)
    attachments[2] = dataclasses.replace(
        attachments[2], joint=hinge, release_time=math.inf, release_angle=0.3
    )
    attachments[1] = dataclasses.replace(
        attachments[1],
        joint=dataclasses.replace(hinge, type="cylindrical"),
        release_time=math.inf,
        release_travel=0.3,
    )
    separation = dataclasses.replace(separation, attachments=tuple(attachments))
    events = Events(BatchEquations(separation))
    assert which(events.known) == [
        kind.__name__ for kind in (TimedReleases, TimedStrokeEnds, LoadRows)
    ]
    kinds = (
        *(ProfileCorners, StrokeEnds, LiftOffs),
        *(ReleasesAtAngle, ReleasesAfterTravel),
    )
    assert which(events.crossings) == [kind.__name__ for kind in kinds]
    latches = [kind.latches for kind in events.crossings]
    assert latches == [False, True, False, True, True]
    # Three springs, with a corner each, and two joints, which may move either way.
    assert [kind.count for kind in events.crossings] == [3, 3, 3, 2, 2]


def test_a_release_starts_its_load_at_the_same_time():
    lanes = Lanes(pair(loads=(retro(),)))
    assert lanes.latch(0.0).all()  # the first release
    assert lanes.released == [0.0, math.inf, math.inf]
    assert lanes.next_known == RELEASE
    assert not lanes.latch(0.02).any()
    assert lanes.latch(RELEASE).all()
    assert lanes.released == [0.0, RELEASE, RELEASE]
    assert np.asarray(lanes.mode.passed)[:, 0].tolist() == [True, False]
    # Eq. 5: a quarter of a period after the first release
    spring = generic_pair().springs[0]
    quarter = (
        0.5 * math.pi * math.sqrt(spring.design_mass * spring.stroke / spring.force_max)
    )
    assert lanes.next_known == pytest.approx(quarter, rel=1e-15)


def test_one_by_one_each_has_a_step_of_no_length():
    lanes = Lanes(pair(loads=(retro(),)), one_by_one=True)
    lanes.latch(0.0)
    seen = []
    while lanes.latch(RELEASE).all():
        seen.append((lanes.released[1:], int(lanes.mode.passed.sum())))
        ahead = lanes.next_known - RELEASE
        # The next step has no length, until all has happened.
        assert (ahead == 0.0) == (len(seen) < 3)
    assert seen == [
        ([RELEASE, math.inf], 0),
        ([RELEASE, RELEASE], 0),
        ([RELEASE, RELEASE], 1),
    ]


def test_each_of_coinciding_events_brings_its_own_derivative():
    """Of the end of a step that runs to two releases: one by one it is the first's."""
    separation = pair()
    equations = BatchEquations(separation)
    events = Events(equations, one_by_one=True)
    nominal = equations.params(parameters(separation), 1)
    _, mode = equations.start(nominal)

    def end(times):
        return events.next_known(nominal._replace(release_time=times), mode)

    first = mode.released.at[0].set(0.0)
    mode = mode._replace(released=first)
    for i in (1, 2):
        _, slope = jax.jvp(
            end, (nominal.release_time,), (jnp.zeros((3, 1)).at[i].set(1.0),)
        )
        assert slope.item() == (1.0 if i == 1 else 0.0)
    # The first has happened: the second is as near, and brings its own.
    mode = mode._replace(released=first.at[1].set(RELEASE))
    _, slope = jax.jvp(
        end, (nominal.release_time,), (jnp.zeros((3, 1)).at[2].set(1.0),)
    )
    assert slope.item() == 1.0


def test_lanes_do_not_wait_for_each_other():
    lanes = Lanes(pair(release_times=(RELEASE,)), n=2)
    fresh = lanes.latch([0.5 * RELEASE, RELEASE])
    assert fresh.tolist() == [False, True]
    assert np.isinf(lanes.mode.released[0]).tolist() == [True, False]


# Crossings.


def test_a_stroke_end_latches_where_its_step_was_cut():
    lanes = Lanes(pair(release_times=(0.0,), springs=by_displacement))
    lanes.latch(0.0)
    assert not lanes.mode.spent.any()
    fresh = lanes.latch(0.1, lanes.moved([STROKE]), lanes.all_of(StrokeEnds))
    assert fresh.all()
    assert lanes.mode.spent.all()
    assert lanes.latched.stroke_ends.tolist() == [[0.1]]
    assert not any(watched.any() for watched in lanes.latched.watched)  # no more


@pytest.mark.parametrize(
    ("kind", "flag"), [(ProfileCorners, "corners"), (LiftOffs, "lifted")]
)
def test_a_corner_changes_sides_and_nothing_is_guessed_anew(kind, flag):
    lanes = Lanes(pair(release_times=(0.0,), springs=by_displacement))
    lanes.latch(0.0)
    before = lanes.mode
    for beyond in (True, False):  # there, and back
        assert not lanes.latch(0.1, lanes.moved([0.02]), lanes.all_of(kind)).any()
        assert getattr(lanes.mode, flag).tolist() == [[beyond]]
    assert all(map(np.array_equal, lanes.mode, before))


def test_what_begins_to_be_watched_may_have_happened_already():
    """The pad has moved past its stroke in a soft joint, before it is released."""
    lanes = Lanes(pair(release_times=(RELEASE,), springs=by_displacement))
    far = lanes.moved([1.01 * STROKE])
    assert not lanes.latch(0.0, far).any()
    assert not lanes.mode.spent.any()
    assert lanes.latch(RELEASE, far).all()
    assert lanes.mode.spent.all()
    assert lanes.latched.stroke_ends.tolist() == [[RELEASE]]
    assert lanes.mode.corners.all()


@pytest.mark.parametrize(("speed", "lifted"), [(9.0, False), (9.5, True)])
def test_a_pad_is_released_beyond_a_corner(speed, lifted):
    """Which piece of its force acts is known before whether it has lifted off.

    At half the stroke the profile's second piece gives 1500 (0.9 - 0.7 / 3) = 1000 N,
    which its damper of 100 N s/m takes at 10 m/s; its first, gone on, 1200 N.
    """
    lanes = Lanes(pair(release_times=(RELEASE,), springs=by_displacement))
    lanes.latch(0.0)
    for factor in (1.0, 1.2):
        assert not lanes.mode.lifted.any()
        x = lanes.moved([0.5 * STROKE], speed * factor / 0.9)
        before = lanes.latched
        lanes.latch(RELEASE, x)
        assert lanes.mode.corners.all()
        assert lanes.mode.lifted.tolist() == [[lifted or factor > 1.0]]
        lanes.latched = before


def test_the_first_crossing_of_a_step_is_found():
    """B moves evenly from the mated place to two strokes: corner, then end."""
    lanes = Lanes(pair(release_times=(0.0,), springs=by_displacement), n=2)
    lanes.latch(0.0)
    reach = 2.0 * STROKE * np.array([1.0, 0.1])  # the second lane meets nothing

    def first(nodes):
        nodes = body_state(lanes.moved(nodes), 0, 7)
        found = lanes.events.find(lanes.latched, nodes, jnp.ones(2), lanes.params)
        fraction, crossed = lanes.events.first(found)
        return found, fraction, lanes.events.by_kind(crossed)

    found, fraction, crossed = first(lobatto.THETA[:, None] * reach)
    assert np.asarray(found.beyond.any(axis=(0, 1))).tolist() == [True, False]
    assert fraction.tolist() == pytest.approx([0.5 * CORNER, 1.0], rel=1e-13)
    of_first = [now[:, 0].any().item() for now in crossed]
    assert of_first == [True, False, False]  # the corner
    assert not any(now[:, 1].any() for now in crossed)
    # Beyond the corner the end comes first.
    lanes.latch(0.1, crossed=crossed)
    begin = CORNER * STROKE * np.array([1.0, 0.1])
    found, fraction, crossed = first(begin + lobatto.THETA[:, None] * (reach - begin))
    end = (1.0 - CORNER) / (2.0 - CORNER)
    assert fraction.tolist() == pytest.approx([end, 1.0], rel=1e-13)
    assert [now[:, 0].any().item() for now in crossed] == [False, True, False]


def test_the_next_crossing_is_foreseen():
    """B speeds up evenly: what a parabola foresees is when it is there."""
    lanes = Lanes(pair(release_times=(0.0,), springs=by_displacement), n=4)
    lanes.latch(0.0)
    # Over the step: away from the corner at 0.02 m; to 0.003 m before it; towards it,
    # but slowed down so much that it does not get there; and back to it from beyond.
    at, speed, acceleration = np.array(
        [
            [0.01, -0.02, 0.0],
            [0.005, 0.01, 0.004],
            [0.005, 0.006, -0.002],
            [0.028, -0.005, 0.0],
        ]
    ).T
    assert CORNER * STROKE == 0.02
    mode = lanes.mode._replace(corners=jnp.array([[False, False, False, True]]))
    latched = lanes.latched._replace(mode=mode)
    theta = lobatto.THETA[:, None]
    way = at + speed * theta + 0.5 * acceleration * theta**2
    nodes = body_state(lanes.moved(way), 0, 7)
    found = lanes.events.find(latched, nodes, jnp.ones(4), lanes.params)
    towards = (math.sqrt(0.014**2 + 2.0 * 0.004 * 0.003) - 0.014) / 0.004
    for fraction, rest in (
        (1.0, 0.0),
        (0.5, 0.5),
    ):  # cut after half of it: as much more
        ahead = lanes.events.foresee(found, jnp.full(4, fraction), mode)
        expected = [math.inf, rest + towards, math.inf, rest + 0.6]
        assert ahead.tolist() == pytest.approx(expected, rel=1e-9)


def test_a_step_that_was_not_taken_crosses_nothing():
    lanes = Lanes(pair(release_times=(0.0,), springs=by_displacement))
    lanes.latch(0.0)
    nodes = body_state(lanes.moved(lobatto.THETA[:, None] * 2.0 * STROKE), 0, 7)
    found = lanes.events.find(lanes.latched, nodes, jnp.zeros(1), lanes.params)
    assert not found.beyond.any()


def test_known_times_end_with_the_run():
    separation = pair(release_times=(0.0,), springs=by_displacement)
    lanes = Lanes(separation)
    lanes.latch(0.0)
    # Its spring ends where its pad is, at no known time.
    assert lanes.next_known == separation.duration


def test_a_spring_of_no_force_is_out_at_its_release():
    """Pressed in or not: its pad has no stroke to travel. Its neighbours have."""

    def springs(name):
        spring = dataclasses.replace(by_displacement(name), damping=0.0)
        force = 0.0 if name == "spring_2" else spring.force_max
        return dataclasses.replace(spring, force_max=force)

    lanes = Lanes(pair(springs=springs), n=2)
    lanes.latch(RELEASE, lanes.moved([0.0, -1e-3]))
    assert np.asarray(lanes.latched.mode.spent).tolist() == [
        [False, False],
        [True, True],
        [False, False],
    ]
    assert lanes.latched.stroke_ends[1] == pytest.approx([RELEASE, RELEASE])
