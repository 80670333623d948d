from microfacet.statements.statement import equations


def fingerprints() -> dict[str, str]:
    return {key: f"{e.closed} {e.kernel}" for key, e in equations.items()}
