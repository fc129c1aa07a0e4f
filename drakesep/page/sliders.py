"""Sliders over parameters as an element of the page."""

from collections.abc import Callable, Mapping
from typing import Any

from nicegui.element import Element

from drakesep.page.playing import Playing


class Sliders(  # type: ignore[call-arg]
    Element, component="sliders.js", esm={"drakesep-page": "js"}
):
    """A slider and a field for each parameter that is played with."""

    def __init__(self, move: Callable[[Mapping[str, float]], Any]):
        """Show none yet.

        Args:
            move: called with what has moved: values by parameter name with unit.
        """
        super().__init__()
        self._props["sliders"] = []
        self.on("move", lambda event: move(event.args))

    def show(self, playing: Playing) -> None:
        """Show the sliders as they are now."""
        self._props["sliders"] = [
            {
                **{"name": each.name, "words": each.words, "unit": each.unit},
                **{"low": each.low, "high": each.high, "step": each.step},
                **{"nominal": each.nominal},
                "value": playing.values.get(each.name, each.nominal),
            }
            for each in playing.played.values()
        ]
        self.update()
