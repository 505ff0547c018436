"""Rigid bodies: mass, friction, convex parts, and how objects fall, lean and pile until they are at rest."""
