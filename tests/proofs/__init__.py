"""Measurements of the renderer against closed forms, for `bench/physics.py` and for the tests.

Each function measures one law and returns `check.Check` rows: what the law says, what was measured, how far a right
implementation may be off, and why.
"""
