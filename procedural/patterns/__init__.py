"""Patterns of surfaces at a scale in metres: colour, roughness and relief of wood, stone, cloth, metal and print."""
