"""Derivatives of path-traced pictures by path replay and score functions."""
