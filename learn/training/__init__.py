"""Losses, and the run that lowers them."""
