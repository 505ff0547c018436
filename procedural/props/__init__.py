"""Opaque props: procedural shapes and meshes from a folder."""
