"""Colour cameras: from the light of a picture to what a device reports, on NumPy arrays alone."""
