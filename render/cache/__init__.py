"""Light once per scene: what arrives at the opaque surfaces, stored, and read by every picture."""
