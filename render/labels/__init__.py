"""Per-pixel geometry without noise: straight and refracted rays through exact pixel centres."""
