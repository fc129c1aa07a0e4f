"""The Drake systems of one separation."""
