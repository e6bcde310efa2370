"""From a scene to its asset."""
