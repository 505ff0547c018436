"""Frozen types of a scene description, free of any renderer."""
