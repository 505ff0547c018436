"""Layouts of depth completion."""
