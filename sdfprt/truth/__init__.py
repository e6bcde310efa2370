"""What pictures are held against: path tracing, exact transfer, and the report of errors."""
