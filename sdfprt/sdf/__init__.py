"""Signed distance fields: scenes, measurements, tracing and surfaces."""
