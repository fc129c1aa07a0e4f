"""How plots look, and how they are saved."""

from pathlib import Path
from typing import TYPE_CHECKING

from drakesep.files import written


if TYPE_CHECKING:  # half a second to import, where something is drawn
    from matplotlib.figure import Figure


# Okabe and Ito's colours, told apart by the colour-blind; dashes tell apart curves
# that coincide. Published runs stay in the background.
COLOURS = ("#000000", "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00")
DASHES = ((0, ()), (0, (6, 2)), (0, (2, 2)), (0, (6, 2, 1, 2)), (0, (1, 1)))
LIMIT = "#B00020"


def save_plot(figure: "Figure", file: Path, *, dpi: float = 130) -> None:
    """Write a figure into a file, whole or not at all."""
    with written(file) as beside:
        figure.savefig(beside, dpi=dpi)
