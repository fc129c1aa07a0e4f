"""What goes in and what comes out: frozen records, free of Drake and JAX."""
