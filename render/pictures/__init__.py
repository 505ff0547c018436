"""Path-traced pictures: sampler, path tracer, film, adaptive sampling, denoiser guides, firefly filter, denoiser."""
