"""Whether a model is one: the validation equations, integrals with their own error, enclosures, statistical tests."""
