"""Depth cameras by name, and from files."""
