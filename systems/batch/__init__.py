"""Many separations at once, in JAX; free of Drake."""
