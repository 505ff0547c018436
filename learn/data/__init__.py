"""Samples of several views out of a data set."""
