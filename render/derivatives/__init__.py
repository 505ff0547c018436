"""Derivatives of path-traced pictures: paths walked a second time."""
