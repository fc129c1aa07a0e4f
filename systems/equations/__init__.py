"""Each equation once, on floats or on lanes of arrays; free of Drake and JAX."""
