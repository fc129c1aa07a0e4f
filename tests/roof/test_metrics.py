"""A metric that is registered is a requirement, an objective and a column."""

import re
from pathlib import Path

import pandas as pd
import pytest
from toy_metrics import RELATIVE, RELATIVE_MIN, registered

import drakesep
from drakesep.analysis.metrics.metric import Functional, Metric
from drakesep.analysis.metrics.quantities import QUANTITIES, Quantity
from drakesep.analysis.metrics.registry import DEVIATION, registered_metrics
from drakesep.case_file.case import Case
from drakesep.units import unit_of, with_unit


PAGE = Path(__file__).parents[2] / "docs" / "metrics.md"
NAME, KEY = RELATIVE.names[1], "toy_rate_after_separation_y_deg_s"


@pytest.fixture
def toy():
    with registered(RELATIVE, RELATIVE_MIN):
        yield


def vega_limited(**requirement) -> Case:
    """The built-in case with this requirement alone, and one tolerance."""
    return vega_with([requirement])


def vega_with(requirements) -> Case:
    data = drakesep.load_case("vega").model_dump(mode="json", exclude_none=True)
    data["requirements"] = requirements
    data["dispersions"] = {"payload.cg_y_mm": 10.0}
    data["published"] = []
    return Case.model_validate(data)


def test_column_of_the_summary(toy, tmp_path):
    drakesep.simulate("vega").save(tmp_path)
    [row] = pd.read_csv(tmp_path / "summary.csv").to_dict("records")
    motion = pd.read_csv(tmp_path / "motion.csv")
    after = motion["time_s"] >= row["separation_end_s"]
    largest = motion.loc[after, "relative_rate_y_deg_s"].abs().max()
    # Between samples of 10 ms it is no larger than by their curvature.
    assert row[KEY] == pytest.approx(largest, rel=1e-5)


@pytest.mark.parametrize(
    ("sense", "limit", "met", "objective", "judged_by"),
    [
        ("at_most", 1.0, True, f"highest_{NAME}", RELATIVE),
        ("at_most", 0.01, False, f"highest_{NAME}", RELATIVE),
        ("at_least", 0.1, None, f"lowest_{RELATIVE_MIN.names[1]}", RELATIVE_MIN),
    ],
)
def test_requirement_of_a_case(toy, sense, limit, met, objective, judged_by):
    case = vega_limited(
        quantity="toy_rate_after_separation_deg_s", **{sense: [9.0, limit, 9.0]}
    )
    study = drakesep.verify(case, searches=["drake"], workers=1)
    verdict = study.requirements.set_index("axis").loc["y"]
    assert verdict["requirement"] == "toy rate after separation"
    assert verdict["unit"] == "deg/s"
    assert objective in {worst.name for worst in study.worst}
    # Of the nominal and of the worst run, the one that is nearer to the limit.
    column = study.table[with_unit(judged_by.names[1])]
    worst = column.max() if sense == "at_most" else column.min()
    assert verdict["worst"] == pytest.approx(worst, rel=1e-12)
    if met is None:
        met = worst >= limit
    assert verdict["verdict"] == ("met" if met else "not met")


def test_objective_by_its_name(toy):
    """By the batch engine and its derivatives, confirmed in Drake."""
    study = drakesep.worst_case(
        vega_limited(quantity="final_rate_deg_s", at_most=[9.0, 9.0, 9.0]),
        [f"highest_{NAME}"],
        searches=["vertices", "sqp"],
        workers=1,
    )
    [row] = study.evidence.to_dict("records")
    assert row["unit"] == "deg/s"
    assert row["worst"] == pytest.approx(row["in_drake"], rel=1e-6)
    nominal = study.table[KEY].iloc[0]
    assert study.completed and row["worst"] > nominal


@pytest.mark.parametrize("metric", registered_metrics(), ids=lambda metric: metric.stem)
def test_every_metric_has_a_unit_and_may_be_required(metric):
    quantity = with_unit(metric.stem)
    assert with_unit(metric.names[-1]) == (
        f"{metric.names[-1]}_{unit_of(metric.stem).suffix}"
    )
    if metric.of_every_run:  # else it needs geometry
        limit = [2.0] * len(metric.axes)
        wanted = [{"quantity": quantity, "at_least": limit}]
        if metric.functional is Functional.TIME_WITHIN:
            with pytest.raises(ValueError, match="needs a requirement '<=' on deviati"):
                vega_with(wanted)
            limits = {"quantity": with_unit(DEVIATION), "at_most": [9.0, 9.0, 9.0]}
            wanted.append(limits)
        case = vega_with(wanted)
        mine = [r for r in case.limits if r.sense == ">="]
        assert [r.metric for r in mine] == list(metric.names)
        [first, *_] = case.limits
        assert unit_of(metric.stem).from_si(first.limit) == pytest.approx(2.0)


def test_a_limit_from_above_may_be_below_zero_where_the_metric_may():
    [limit] = vega_limited(quantity="G_PM_m_s", at_most=-0.5).limits
    assert limit.limit == -0.5
    with pytest.raises(ValueError, match="G_L1_deg: at_most must be >= 0, got -1"):
        vega_limited(quantity="G_L1_deg", at_most=-1)
    with pytest.raises(ValueError, match="G_L1_deg: at_least must be > 0, got 0"):
        vega_limited(quantity="G_L1_deg", at_least=0)


def row_of(metric: Metric) -> str:
    axes = f"{', '.join(metric.axes)}" if metric.axes != ("",) else ""
    return f"| `{with_unit(metric.stem)}` | {axes} | {metric.words} |"


def test_the_page_lists_every_metric():
    text = PAGE.read_text(encoding="utf-8")
    listed = re.findall(r"^\| `.*$", text, re.M)
    metrics = [row_of(metric) for metric in registered_metrics()]
    assert listed == [*metrics, *map(row_of_quantity, QUANTITIES.values())]


def row_of_quantity(quantity: Quantity) -> str:
    axes = f"{', '.join(quantity.signal.axes)}"
    limits = "of its magnitude" if quantity.two_sided else "of its value"
    name, words = with_unit(quantity.name), quantity.signal.words
    return f"| `{name}` | {axes} | {words} | {limits} |"
