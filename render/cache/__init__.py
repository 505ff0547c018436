"""Irradiance cache: points on opaque surfaces, filled once per scene and read by the tracer of all pictures."""
