"""Depth cameras: from infrared light to the depth that a device reports, on NumPy arrays alone."""
