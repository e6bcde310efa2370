"""Transfer: cosine-weighted visibility in SH, by tracing rays."""
