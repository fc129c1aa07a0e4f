"""`python -m drakesep.check_proof`: the command, where python-flint is installed."""

import sys
from importlib.util import find_spec


def main() -> int:
    """Run the command; say what it needs where that is missing."""
    if find_spec("flint") is None:
        need = "check_proof needs python-flint: pip install python-flint"
        print(need, file=sys.stderr)
        return 2
    from .command import main as check

    return check()


if __name__ == "__main__":
    sys.exit(main())
