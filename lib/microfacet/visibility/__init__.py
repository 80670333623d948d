"""What of the microsurface is seen: masking, shadowing, visible normals."""
