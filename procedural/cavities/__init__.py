"""Where a solid holds liquid: its cavities, their volumes and brims, and the cut along a level."""
