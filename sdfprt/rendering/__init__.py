"""From scene, asset, light and camera to a picture."""
