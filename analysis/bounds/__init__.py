"""Bounds that cannot be exceeded, proven by enclosures; see docs/proof.md."""
