"""How near parts come to each other in runs."""
