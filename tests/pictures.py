"""Whether something is drawn in a picture."""

from pathlib import Path

import numpy as np
from matplotlib import image


def is_drawn(path: Path) -> bool:
    """Whether a picture has lines on its ground, and colours beside black and white."""
    pixels = image.imread(path)[..., :3]
    ground = pixels[0, 0]
    inked = (np.abs(pixels - ground) > 0.1).any(axis=-1)
    coloured = np.ptp(pixels, axis=-1) > 0.2
    # Axes and text alone ink a hundredth of a picture, and colour nothing.
    return bool(0.01 < inked.mean() < 0.9 and coloured.mean() > 1e-3)
