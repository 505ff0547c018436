"""Layouts of radiance fields, and point clouds."""
