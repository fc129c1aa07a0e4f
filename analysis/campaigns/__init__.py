"""How large a share of launches is within limits, at a stated confidence."""
