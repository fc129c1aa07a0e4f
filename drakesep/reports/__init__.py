"""Readers of results folders: reports. Nothing is flown."""
