"""The study of the worst cases."""
