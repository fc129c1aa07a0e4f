"""Pictures of the motion, after the paper's Figs. 6 and 7, and of requirements on it.

Each signal has two panels beside each other: the push, and the whole run. The run that
decides a requirement is drawn against its limit and named above, and so that it can be
followed it is drawn for all signals along the same axis.
"""

import math
from collections.abc import Sequence
from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from drakesep.analysis.analysis_case import AnalysisCase
from drakesep.analysis.metrics.requirements import Verdict
from drakesep.plots.layout import Layout
from drakesep.plots.limits import limit_words
from drakesep.plots.motion_curves import (
    END,
    draw_curves,
    drawn_everywhere,
    fit,
    legend_entries,
    with_deciding,
)
from drakesep.plots.panels import ROTATION, TRANSLATION, Panel, Topic, panels_of
from drakesep.plots.shown_runs import Decided, ShownRuns
from drakesep.plots.style import save_plot
from drakesep.systems.model.run import Run
from drakesep.systems.model.separation import Pair
from drakesep.tables.labelled_run import LabelledRun


_SHADE = "#F3F3F3"
"""Of the push."""
_AROUND = 0.15
"""Of the push, that is shown before and after it."""
_LEAST = 0.001
"""Of the run, that is shown there if nothing pushes."""


def save_motion(runs: Sequence[LabelledRun], case: AnalysisCase, folder: Path) -> None:
    """Write translation.png and rotation.png of a study's runs into a folder.

    Those of other bodies that leave end with their names.

    Args:
        runs: of the study; those that failed are left out.
        case: with the requirements.
        folder: that receives them.
    """
    shown = ShownRuns.of(runs, case)
    for pair in shown.run.separation.pairs:
        end = "" if pair == shown.run.separation.pairs[0] else f"_{pair.B}"
        for name, topic in (("translation", TRANSLATION), ("rotation", ROTATION)):
            save_plot(motion_figure(topic, shown, pair), folder / f"{name}{end}.png")


def motion_figure(topic: Topic, shown: ShownRuns, pair: Pair) -> Figure:
    """Return signals of a body that leaves over time, with what is required of them.

    Args:
        topic: what it is about.
        shown: runs of the study.
        pair: whose B leaves.
    """
    run = shown.run
    panels = panels_of(topic, run.separation, pair, shown.decided)
    compared = [o for o in shown.compared if topic.concerns(o, run.separation, pair.B)]
    everywhere = drawn_everywhere(shown.reference, compared)
    drawn_in = [with_deciding(everywhere, _deciding(p, panels)) for p in panels]
    layout = Layout(
        topic.title.format(A=pair.A, B=pair.B).replace("_", " "),
        [[_sentence(panel, decided) for decided in panel.decided] for panel in panels],
        legend_entries(everywhere, panels, drawn_in),
    )
    for k, (panel, drawn) in enumerate(zip(panels, drawn_in, strict=True)):
        both = push, whole = layout.panels(k, panel.title, panel.unit.symbol)
        _zoom(push, whole, run, pair)
        for axes in both:
            draw_curves(axes, panel, drawn, pair)
            fit(axes)
            if math.isfinite(end := run.end_of(pair.B)):
                axes.axvline(end, **END)
        layout.write(k, [drawn[decided.run.label].colour for decided in panel.decided])
    return layout.figure


def _deciding(panel: Panel, panels: Sequence[Panel]) -> list[LabelledRun]:
    """Return the runs that decide requirements along the same axis, or along none."""
    along = [other for other in panels if other.column is None]
    if panel.column is not None:
        along += [other for other in panels if other.column == panel.column]
    return [decided.run for other in along for decided in other.decided]


def _sentence(panel: Panel, decided: Decided) -> str:
    """Return what is said above a panel of a requirement on it."""
    finding = decided.finding
    limit, unit = limit_words(finding.requirement), panel.unit
    verdict = finding.verdict_on_runs
    if verdict is Verdict.NOT_LOOKED_AT:
        return f"{limit}: {verdict.value}"
    worst = unit.from_si(finding.worst) + 0.0  # of -0, 0
    # Of a share of launches, one that is beyond the limit is no verdict.
    beyond = "beyond it" if finding.requirement.statistical else verdict.value
    broken = "" if verdict is Verdict.MET else f", {beyond}"
    return f"{limit}: {worst:.4g} in {finding.run}{broken}"


def _zoom(push: Axes, whole: Axes, run: Run, pair: Pair) -> None:
    """Show the push in the one panel, and where it is in the other."""
    start, end = run.push_of(pair)
    duration = run.separation.duration
    around = max(_AROUND * (end - start), _LEAST * duration)
    push.set_xlim(max(start - around, 0.0), min(end + around, duration))
    whole.set_xlim(0.0, duration)
    whole.axvspan(*push.get_xlim(), color=_SHADE, zorder=0)
    push.set_facecolor(_SHADE)
