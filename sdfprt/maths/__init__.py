"""Directions, sequences and spherical harmonics."""
