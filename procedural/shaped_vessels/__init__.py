"""Vessels that are no solids of revolution: other cross-sections, handles, spouts, double walls."""
