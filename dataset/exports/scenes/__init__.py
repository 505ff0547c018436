"""Scenes with meshes and physical properties, for simulators and Blender."""
