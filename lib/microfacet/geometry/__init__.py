"""What the microsurface looks like: distributions of normals."""
