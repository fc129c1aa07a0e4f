"""How a report says distributions and shapes, so that a reader has every number."""

import pytest

from drakesep.analysis.tolerances.box import Dispersion
from drakesep.analysis.tolerances.distributions import Discrete, Normal, Table
from drakesep.reports.separation_part import _shape_words
from drakesep.systems.model.parts import Cone
from drakesep.tables.columns import values_text


@pytest.mark.parametrize(
    ("distribution", "words"),
    [
        (Table(values=(388.0, 395.0), weights=(1.0, 2.0)), "388 (1), 395 (2)"),
        (Table(values=(388.0, 395.5)), "388, 395.5"),
        (
            Discrete(values=(388.0, 402.0), probabilities=(0.3, 0.7)),
            "388 (0.3), 402 (0.7)",
        ),
        (Normal(sigma=2.0), ""),
    ],
)
def test_values_stand_with_their_weights(distribution, words):
    one = Dispersion(name="s.force_max", nominal=390.0, tolerance=distribution)
    assert values_text(one) == words


def test_a_cylinder_is_no_cone():
    even = Cone(radius_aft=0.35, radius_fore=0.35, length=0.3, thickness=0.02)
    assert _shape_words(even) == "cylinder, radius 350, length 300, wall 20 mm"
    cone = Cone(radius_aft=0.285, radius_fore=0.09, length=0.32)
    assert _shape_words(cone) == "cone, radii 285 aft, 90 fore, length 320 mm"
