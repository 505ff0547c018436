"""Writes other people's data sets in our format, and shows what is in them."""
