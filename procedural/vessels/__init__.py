"""Vessels: outline, wall, surface of revolution, interfaces, liquid."""
