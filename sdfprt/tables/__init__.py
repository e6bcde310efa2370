"""What holds transfer beside a network: tables, a row a vertex or a texel."""
