"""Colours and dashes of plots."""

# Okabe and Ito's colours, told apart by the colour-blind; dashes tell apart curves
# that coincide. Published runs stay in the background.
COLOURS = ("#000000", "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00")
DASHES = ((0, ()), (0, (6, 2)), (0, (2, 2)), (0, (6, 2, 1, 2)), (0, (1, 1)))
LIMIT = "#B00020"
