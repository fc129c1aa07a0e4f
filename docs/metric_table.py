"""The metrics, from their registry, as the page on them lists them."""

from drakesep.analysis.metrics.registry import registered_metrics
from drakesep.units import with_unit


def table_of_metrics() -> str:
    """Return the registered metrics, as Markdown."""
    rows = [
        f"| `{with_unit(metric.stem)}` | {', '.join(metric.axes)} | {metric.words} |"
        for metric in registered_metrics()
    ]
    return "\n".join(["| metric | axes | what it is |\n|---|---|---|", *rows])
