"""Vessels from files of the user: read, checked and repaired as solids, and drawn with a filling."""
