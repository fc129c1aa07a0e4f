"""What a user asks for: simulate, sweep, animate, clearance, worst case, verify."""
