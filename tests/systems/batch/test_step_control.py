"""Step control as functions of numbers whose answers are known."""

import dataclasses
import math

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from separations import generic_pair

from drakesep.systems.batch import step_control
from drakesep.systems.batch.equations import BatchEquations
from drakesep.systems.batch.step_control import StepControl
from drakesep.systems.batch.tableaus import DOP853, DOPRI5
from drakesep.systems.model.joints import Joint
from drakesep.systems.model.parameters import parameters
from drakesep.systems.model.separation import Attachment
from drakesep.systems.model.springs import DisplacementSpring


TOLERANCE = 1e-8
"""At which a first guess is 0.8 rad of the fastest motion."""


@pytest.fixture(autouse=True)
def double_precision():
    with jax.enable_x64(True):
        yield


def still(separation):
    initial = dataclasses.replace(separation.initial, w_WA_A=(0.0,) * 3)
    return dataclasses.replace(separation, initial=initial)


def first_guess(separation, released) -> float:
    equations = BatchEquations(separation)
    params = equations.params(parameters(separation), 1)
    x, mode = equations.start(params)
    times = (
        jnp.full_like(mode.released, jnp.inf)
        .at[: len(released), 0]
        .set(jnp.array(released))
    )
    mode = mode._replace(released=times)
    return StepControl(equations, TOLERANCE).first_guess(x, params, mode).item()


def phase(guess: float) -> float:
    """The frequency that a first guess has been made for, rad/s."""
    return 0.8 / guess - 1e-3


def test_guess_for_a_spring_by_time():
    separation = still(generic_pair(release_times=(0.0,)))
    [spring] = separation.springs
    w = math.sqrt(spring.force_max / (spring.design_mass * spring.stroke))  # Eq. 5
    assert phase(first_guess(separation, [0.0])) == pytest.approx(w, rel=1e-12)


def test_guess_for_a_spring_by_displacement():
    """The frequency of two masses on a spring: sqrt(k (1/m_1 + 1/m_2))."""
    separation = still(generic_pair(release_times=(0.0,)))
    spring = DisplacementSpring(name="spring_1", force_max=1500.0, stroke=0.08)
    [attachment] = separation.attachments
    attachment = dataclasses.replace(attachment, spring=spring)
    separation = dataclasses.replace(separation, attachments=(attachment,))
    w = math.sqrt(1500.0 / 0.08 * (1.0 / 700.0 + 1.0 / 1200.0))
    assert phase(first_guess(separation, [0.0])) == pytest.approx(w, rel=1e-12)


def test_guess_for_a_spring_that_moves_what_is_welded_to_a_body():
    """By a pad of which the body is A, and one of which it is B: it weighs once."""
    separation = still(generic_pair(release_times=(0.0,)))
    lower, upper = separation.bodies
    third = dataclasses.replace(upper, name="third", mass=300.0)
    [pushed] = separation.attachments
    spring = DisplacementSpring(name="spring_1", force_max=1500.0, stroke=0.08)
    welds = tuple(
        Attachment(
            name=f"weld_{A}",
            A=A,
            B=B,
            p_AoPad_A=pushed.p_AoPad_A,
            joint=Joint(rigid=True),
            release_time=0.5,
        )
        for A, B in ((upper.name, "third"), ("third", upper.name))
    )
    separation = dataclasses.replace(
        separation,
        bodies=(lower, upper, third),
        attachments=(dataclasses.replace(pushed, spring=spring), *welds),
    )
    w = math.sqrt(1500.0 / 0.08 * (1.0 / lower.mass + 1.0 / (upper.mass + 300.0)))
    assert phase(first_guess(separation, [0.0])) == pytest.approx(w, rel=1e-12)


def test_guess_for_a_joint_that_holds_at_both_cgs():
    """Without an arm: sqrt(K (1/m_1 + 1/m_2)); with damping alone, its own rate."""
    separation = still(generic_pair(release_times=(0.5,), springs=False))
    bodies = tuple(
        dataclasses.replace(body, p_BoBcm_B=(0.0, 0.0, 0.0))
        for body in separation.bodies
    )
    both = 1.0 / 700.0 + 1.0 / 1200.0
    for gains, expected in (
        ({"K_F": 1e6, "D_F": 0.0}, math.sqrt(1e6 * both)),
        ({"K_F": 0.0, "D_F": 1e5}, 1e5 * both),
    ):
        [attachment] = separation.attachments
        attachment = dataclasses.replace(
            attachment,
            joint=Joint(type="fixed", K_T=0.0, D_T=0.0, **gains),
            p_AoPad_A=(0.0, 0.0, 0.0),
        )
        held = dataclasses.replace(separation, bodies=bodies, attachments=(attachment,))
        assert phase(first_guess(held, [])) == pytest.approx(expected, rel=1e-12)
        # Once it has let go nothing acts.
        assert phase(first_guess(held, [0.5])) == pytest.approx(0.0, abs=1e-12)


def test_a_step_is_guessed_anew_only_where_it_is_fresh():
    separation = still(generic_pair(release_times=(0.0,)))
    equations = BatchEquations(separation)
    params = equations.params(parameters(separation), 2)
    x, mode = equations.start(params)
    control = StepControl(equations, TOLERANCE)
    mode = mode._replace(released=jnp.zeros_like(mode.released))
    guess = control.first_guess(x, params, mode)
    fresh = jnp.array([True, False])
    wanted = control.wanted(jnp.full(2, 1e-4), fresh, x, params, mode)
    assert wanted.tolist() == [guess[0].item(), 1e-4]


def test_a_body_turns_by_no_more_than_its_step_resolves():
    x = jnp.zeros((13, 2, 1)).at[7:10, 1, 0].set(jnp.array([1.0, -2.0, 2.0]))
    # 0.4 rad at 3 rad/s
    assert step_control.largest_step(x).tolist() == pytest.approx([0.4 / 3.0])


@pytest.mark.parametrize(
    ("left", "pieces"),
    [(0.0, 1), (0.3, 1), (1.0, 1), (1.0 + 1e-12, 1), (1.001, 2), (2.5, 3)],
)
def test_equal_steps_to_the_next_known_event(left, pieces):
    assert step_control.pieces(jnp.array([left]), jnp.array([1.0])).item() == pieces


def test_the_length_of_a_step_keeps_the_derivative_of_its_event():
    def length(left):
        return left / step_control.pieces(left, jnp.ones(1))

    _, slope = jax.jvp(length, (jnp.array([2.5]),), (jnp.ones(1),))
    assert slope.item() == pytest.approx(1.0 / 3.0)


@pytest.mark.parametrize(
    ("foreseen", "left", "step"),
    [
        (0.3, 9.0, 0.3),  # to the event
        (2.5, 9.0, 2.5 / 3),  # in equal steps
        (1e-9, 9.0, 0.01),  # beyond it: a step is cut there
        (math.inf, 9.0, 1.0),  # what is known comes first
        (9.5, 0.7, 0.7),
    ],
)
def test_steps_towards_a_foreseen_event(foreseen, left, step):
    got = step_control.towards(
        jnp.array([foreseen]), jnp.array([left]), jnp.array([1.0])
    )
    assert got.item() == pytest.approx(step, rel=1e-12)


def test_until_when_the_next_step_may_go_on():
    """A little beyond what follows a step, or what was found in it; or as it was.

    A step of 0.2 s: taken, with an event after half of its length; not taken, as the
    event at a quarter of it was not known well enough; and rejected for its error.
    """
    got = step_control.beyond_foreseen(
        h=jnp.full(4, 0.2),
        ahead=jnp.array([0.5, 9.0, 9.0, math.inf]),
        fraction=jnp.array([1.0, 0.25, 1.0, 1.0]),
        accepted=jnp.array([True, False, False, True]),
        admitted=jnp.array([True, True, False, True]),
        before=jnp.full(4, 0.7),
    )
    assert 0.1 < got[0] < 0.12
    assert 0.05 < got[1] < 0.0501
    assert got[2] == 0.7
    assert got[3] == math.inf


def test_error_within_a_step():
    """The continuous extension of order seven of a polynomial of that degree.

    It is exact for y' = 7 t^6, whose last term, t^7 - what a term less makes of it, is
    what the error is told by: theta^4 (1 - theta)^3 of h^7, zero at both ends.
    """
    equations = BatchEquations(generic_pair())
    control = StepControl(equations, TOLERANCE)
    h = jnp.array([0.5])
    K = np.zeros((16, 13, 2, 1))
    K[:] = 7.0 * (DOP853.C[:, None, None, None] * h.item()) ** 6
    for theta in (0.0, 0.4, 1.0):
        got = control.cut_error(jnp.asarray(K), DOP853, h, jnp.array([theta]))
        expected = theta**4 * (1.0 - theta) ** 3 * h.item() ** 7 / (0.1 * TOLERANCE)
        assert got.item() == pytest.approx(expected, rel=1e-6, abs=1e-12)
        assert control.cut_error(jnp.asarray(K), DOPRI5, h, jnp.array([theta])) == 0.0


@pytest.mark.parametrize("lifted", [False, True])
def test_a_push_by_displacement_bounds_steps(lifted):
    """0.45 rad of its motion at a tolerance of 1e-8, but where the pad is off."""
    separation = still(generic_pair(release_times=(0.0,)))
    spring = DisplacementSpring(name="spring_1", force_max=1500.0, stroke=0.08)
    [attachment] = separation.attachments
    attachment = dataclasses.replace(attachment, spring=spring)
    separation = dataclasses.replace(separation, attachments=(attachment,))
    equations = BatchEquations(separation)
    params = equations.params(parameters(separation), 1)
    x, mode = equations.start(params)
    mode = mode._replace(
        released=jnp.zeros_like(mode.released),
        lifted=jnp.full_like(mode.lifted, lifted),
    )
    control = StepControl(equations, TOLERANCE)
    w = math.sqrt(1500.0 / 0.08 * (1.0 / 700.0 + 1.0 / 1200.0))
    for fresh in (True, False):
        wanted = control.wanted(jnp.full(1, 9.0), jnp.array([fresh]), x, params, mode)
        if not lifted:
            assert wanted.item() == pytest.approx(0.45 / w, rel=1e-12)
        else:
            assert wanted.item() >= 9.0


@pytest.mark.parametrize(
    ("h", "flying", "short"),
    [
        ([0.029, 0.029], [True, True], True),
        ([0.029, 0.5], [True, True], False),
        ([0.029, 0.5], [True, False], True),
    ],
)
def test_brief_steps_are_taken_only_by_all_that_fly(h, flying, short):
    is_short = step_control.is_short(jnp.array(h), jnp.ones(2), jnp.array(flying))
    assert is_short.item() is short


@pytest.mark.parametrize(
    ("error", "accepted", "step"),
    [
        (1.0, False, 0.9),  # the safety
        (2.0**7, False, 0.45),  # the error falls with the seventh power
        (1e30, False, 0.2),  # at most so much shorter
        (math.nan, False, 0.2),
        (math.inf, False, 0.2),
        (0.9**7, True, 1.0),
        (0.0, True, 6.0),  # at most so much longer
    ],
)
def test_next_step_by_the_error_of_the_last(error, accepted, step):
    got = step_control.next_step(
        jnp.ones(1), jnp.array([error]), 7, jnp.zeros(1), jnp.array([accepted])
    )
    assert got.item() == pytest.approx(step, rel=1e-12)


def test_a_step_cut_by_a_known_event_does_not_make_the_next_short():
    h, wanted = jnp.array([1e-6]), jnp.array([0.1])
    error = jnp.array([1e-9])
    for accepted, step in ((True, 0.1), (False, 6e-6)):
        got = step_control.next_step(h, error, 7, wanted, jnp.array([accepted]))
        assert got.item() == pytest.approx(step)


@pytest.mark.parametrize("method", [DOP853, DOPRI5], ids=["DOP853", "DOPRI5"])
def test_error_is_a_share_of_the_tolerance(method):
    """Twice the tolerance, half the error; it is the root mean square of the states."""
    separation = generic_pair()
    equations = BatchEquations(separation)
    K = np.zeros((16, 13, 2, 1))
    K[: method.stages] = np.random.default_rng(0).normal(
        size=(method.stages, 1, 1, 1)
    )  # alike for all states
    errors = method.errors @ K[:, 0, 0, 0]
    expected = errors[0] ** 2 / math.hypot(errors[0], 0.1 * errors[1])
    for tolerance in (1e-8, 2e-8):
        error = StepControl(equations, tolerance).error(jnp.asarray(K), method)
        share = tolerance / separation.duration
        assert error.item() == pytest.approx(abs(expected) / share, rel=1e-10)
