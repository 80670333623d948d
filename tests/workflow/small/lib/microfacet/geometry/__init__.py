"""The first stage."""
