"""What is in vessels besides liquids: ice, beads, bubbles, and straws, spoons and rods that lean in them."""
