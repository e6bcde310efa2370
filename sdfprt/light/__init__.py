"""Environment lights."""
