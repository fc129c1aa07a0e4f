"""Campaigns: many launches drawn at random, and what they say of requirements."""
