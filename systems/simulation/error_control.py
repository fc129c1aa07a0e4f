"""What Drake's error control is asked for, so that schemes err alike."""

import math
from typing import NamedTuple

from drakesep.systems.model.integration import FINEST, Integration


class _Control(NamedTuple):
    share: float = 1.0
    """Part of the accuracy."""
    longest: float = math.inf
    """Step, s."""


_FREE = {"runge_kutta5": _Control(0.1)}
"""By schemes, if it is not the accuracy: runge_kutta5 then errs by no more than
runge_kutta3, whose short steps are better than their estimate."""
_IN_RECONTACT = {"runge_kutta5": _Control(0.01, 1e-2)}
"""The same where parts may push each other, with kinks that are not foreseen."""
_ELSE_IN_RECONTACT = _Control(longest=5e-3)
"""In free flight error control would step over a contact. All schemes look at forces
twice a step, or more often."""
_FINEST = 0.1 * FINEST
"""Beyond it there is round-off."""


def error_control(integration: Integration, *, recontact: bool) -> tuple[float, float]:
    """Return the accuracy that error control is asked for, and the largest step, s.

    Args:
        integration: how a run is integrated.
        recontact: whether parts may push each other.
    """
    if recontact:
        control = _IN_RECONTACT.get(integration.scheme, _ELSE_IN_RECONTACT)
    else:
        control = _FREE.get(integration.scheme, _Control())
    accuracy = max(control.share * integration.accuracy, _FINEST)
    return accuracy, min(control.longest, integration.max_step)
