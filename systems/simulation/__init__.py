"""Runs of one separation in Drake."""
