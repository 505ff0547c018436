"""Opaque materials and the textures they are painted with."""
