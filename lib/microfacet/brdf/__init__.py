"""The complete model."""
