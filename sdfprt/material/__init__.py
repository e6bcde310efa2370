"""Materials and the shading that joins them with light and transfer."""
