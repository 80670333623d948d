"""Whether a model is one: the validation equations, quadrature, enclosures, statistical tests."""
