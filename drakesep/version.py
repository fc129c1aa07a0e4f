"""The version of drakesep."""

import importlib.metadata


__version__ = importlib.metadata.version("drakesep")
