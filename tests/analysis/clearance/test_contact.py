"""When two parts first touch."""

from types import SimpleNamespace

import pytest

from drakesep.analysis.clearance import contact


def test_a_contact_is_not_lost_to_round_off(monkeypatch):
    """At 1 m/s they touch at 1 s; bounds are too large by more than a step's motion."""
    gap, error = 1.0, 1e-6

    class Closing:
        def may_come_below(self, start, end, limit):
            middle, half = 0.5 * (start + end), 0.5 * (end - start)
            if gap - middle - half + error >= limit:
                return None
            return SimpleNamespace(distance=gap - middle)

    monkeypatch.setattr(
        contact, "contact_at", lambda _, t: contact.Contact(time=t, closing_speed=1.0)
    )
    found = contact.first_contact(Closing(), 0.0, 1.9)
    # To the error of the bounds, and what counts as touching.
    assert found.time == pytest.approx(gap, abs=3e-6)
