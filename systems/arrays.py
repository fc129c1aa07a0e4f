"""Array aliases, once."""

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray


Array: TypeAlias = NDArray[np.float64]
"""Of floats; docstrings give the shape."""
