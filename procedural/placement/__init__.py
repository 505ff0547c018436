"""Where objects stand: resting poses, footprints and overlap."""
