"""Figures of the motion, and what is read off them."""

from typing import NamedTuple

from matplotlib.figure import Figure

from drakesep.analysis.analysis_case import AnalysisCase
from drakesep.plots.motion import motion_figure
from drakesep.plots.panels import ROTATION, TRANSLATION, Topic
from drakesep.plots.shown_runs import ShownRuns


TOPICS = {"rotation": ROTATION, "translation": TRANSLATION}


def drawn(topic: Topic, runs, case: AnalysisCase, body: str = "") -> Figure:
    """The figure of runs of a study, of a body that leaves; the first if empty."""
    pair = case.separation.pair_of(body or case.separation.B)
    return motion_figure(topic, ShownRuns.of(runs, case), pair)


class Curves(NamedTuple):
    """What stands in the panel of a signal."""

    runs: dict
    """Lines by the labels of runs."""
    limits: list
    end: object
    """Of the separation."""
    marks: list
    """Where runs decide: times and values."""


def curves_of(figure: Figure, title: str, part: str = "whole run") -> Curves:
    """What a panel shows: of the push, or of the whole run."""
    [axes] = [a for a in figure.axes if a.get_label() == f"{title}: {part}"]
    *lines, end = axes.get_lines()
    runs = {x.get_label(): x for x in lines if not x.get_label().startswith("_")}
    others = [line for line in lines if line.get_label().startswith("_")]
    marks = [line for line in others if line.get_marker() == "o"]
    return Curves(
        runs,
        [line for line in others if line not in marks],
        end,
        [(float(x.get_xdata()[0]), float(x.get_ydata()[0])) for x in marks],
    )


def titles_of(figure: Figure) -> set[str]:
    """The titles of signals."""
    return {axes.get_label().partition(":")[0] for axes in figure.axes}


def texts_of(figure: Figure) -> list[str]:
    """What is written above signals, with their titles."""
    return [text.get_text() for text in figure.texts]
