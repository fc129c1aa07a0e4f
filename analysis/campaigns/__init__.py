"""Campaigns: many launches at random, and what their draws say of requirements."""
