"""Contact sheets and galleries."""
