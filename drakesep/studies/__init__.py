"""What a user asks for: simulate, animate, clearance, worst case, verify."""
