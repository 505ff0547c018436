"""Everything around the objects: table, environments, area lights, cameras."""
