"""How far tolerances may grow."""
