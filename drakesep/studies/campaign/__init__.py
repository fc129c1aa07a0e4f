"""The study of what share of launches meets the requirements."""
