"""Scenes by hand from a few numbers: `bodies` (ball, slab, prism, vessel, any closed mesh) and `scenes`.

::

    glass = catalogue()["soda-lime glass"]
    bodies = [ball(0.03, glass, (0.0, 0.0, 0.031)), vessel(profile, glass, liquid=water(), place=(0.1, 0.0), id=3)]
    description = metered(scene(bodies, [camera((0.3, -0.4, 0.3))]))
"""
