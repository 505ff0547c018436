"""What a network is to give for a view, and in which units."""
