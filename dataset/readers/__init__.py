"""Reads other people's data sets of transparent objects as one typed view; one module for each layout."""
