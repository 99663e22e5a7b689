"""File formats: each module reads one family of files into a `RawMesh`."""
