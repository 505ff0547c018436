"""Scene loading: shapes, BSDFs and emitters in Mitsuba, and the surface table that the ray loops read."""
