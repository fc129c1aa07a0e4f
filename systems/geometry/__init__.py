"""Shapes of parts: pieces, distances, and how they are drawn."""
