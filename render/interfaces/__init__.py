"""Dielectric interfaces: Fresnel, rough microsurfaces and polarisation (BSDF sampling of glass)."""
