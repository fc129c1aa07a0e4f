"""Metrics and quantities, from their registries, as the page on them lists them."""

from drakesep.analysis.metrics.quantities import QUANTITIES
from drakesep.analysis.metrics.registry import registered_metrics
from drakesep.units import with_unit


def table_of_metrics() -> str:
    """Return the registered metrics, as Markdown."""
    rows = [
        f"| `{with_unit(metric.stem)}` | {', '.join(metric.axes)} | {metric.words} |"
        for metric in registered_metrics()
    ]
    return "\n".join(["| metric | axes | what it is |\n|---|---|---|", *rows])


def table_of_quantities() -> str:
    """Return the quantities that may be limited at any time, as Markdown."""
    rows = []
    for quantity in QUANTITIES.values():
        signal = quantity.signal
        axes = ", ".join(signal.axes)
        limits = "of its magnitude" if quantity.two_sided else "of its value"
        name = with_unit(quantity.name)
        rows.append(f"| `{name}` | {axes} | {signal.words} | {limits} |")
    head = "| quantity | axes | what it is | limits |\n|---|---|---|---|"
    return "\n".join([head, *rows])
