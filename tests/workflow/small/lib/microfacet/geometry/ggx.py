"""A distribution."""


def GGX(alpha: float) -> float:
    return alpha * alpha
