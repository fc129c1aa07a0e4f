"""The set of parameter values that the tolerances admit."""
