"""What one interface does to a ray: smooth, rough and polarised."""
