"""Mesh files as people own them: their layouts, shapes and materials."""
