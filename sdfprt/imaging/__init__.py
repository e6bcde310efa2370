"""Pictures: files, tone, cameras, and how far two pictures are apart."""
