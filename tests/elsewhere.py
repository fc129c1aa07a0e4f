"""What tests ask of a process beside theirs, which imports it from here."""

import sys
import warnings

from drakesep.systems.geometry.meshes import DoubtfulScale


def imported():
    """The packages that are imported there."""
    return {name.partition(".")[0] for name in sys.modules}


def warned_of():
    """What is told of a doubtful scale and of something else."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.warn("check scale", DoubtfulScale, stacklevel=1)
        warnings.warn("another", UserWarning, stacklevel=1)
    return [str(warning.message) for warning in caught]
