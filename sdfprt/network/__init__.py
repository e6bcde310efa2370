"""The network that holds transfer, and its fit."""
