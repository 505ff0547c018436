"""The loaded scene: shapes, materials and lights in Mitsuba, and tables of what each surface parts."""
