"""Pages for browsers, tabs for Shadertoy, and the window."""
