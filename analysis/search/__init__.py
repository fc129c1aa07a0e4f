"""Searches for the worst case, and the evidence for what they find."""
