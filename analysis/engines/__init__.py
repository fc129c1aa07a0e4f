"""What tells a search the objectives at points."""
