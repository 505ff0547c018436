"""A page about a data set: what was drawn, and what it cost."""
