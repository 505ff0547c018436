"""Training: losses, schedule, checkpoints, and the training loop."""
