"""Whole scenes: settings, drawing, validation, and scene files."""
