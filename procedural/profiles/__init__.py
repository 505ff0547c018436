"""Curves in the half plane of revolution: their solids, volumes, and the surfaces of liquids in them."""
