"""Polarisation cameras: mosaic, noise, and Stokes vectors from a mosaic."""
