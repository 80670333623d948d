"""Explicit surfaces: ground truth that the analytic models are held against."""
