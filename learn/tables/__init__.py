"""The paper's tables: what is trained for them, what was published, and how they are written."""
