"""Path-traced pictures: samples, paths and their means, guides, fireflies and the denoiser."""
