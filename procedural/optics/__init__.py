"""Optical media: refractive index and absorption, with their sources."""
