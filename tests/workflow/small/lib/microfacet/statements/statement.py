"""Statements whose check compares a kernel with a closed form at a few points."""

from dataclasses import dataclass
from math import sqrt
from typing import Any


@dataclass(frozen=True)
class Equation:
    key: str
    title: str
    slides: tuple[int, ...]
    cite: str
    latex: str
    closed: str
    kernel: str

    @property
    def computed_latex(self) -> str:
        return self.latex

    def check(self) -> dict[str, Any]:
        points = (0.25, 1.0, 3.0)
        pairs = [[eval(code, {"a": a, "sqrt": sqrt}) for code in (self.closed, self.kernel)] for a in points]
        worst = max(abs(exact - computed) for exact, computed in pairs)
        numeric = {
            "status": "pass" if worst < 1e-12 else "fail",
            "detail": f"off by {worst:.1e} at worst",
            "measured": {"float64": {"ulps": worst * 2**52, "at": "a", "promised": 1.0}},
        }
        verdict, message = (
            ("pass", "")
            if worst < 1e-12
            else ("fail", f"{self.key} (microfacet.statements.statement): numeric: {numeric['detail']}")
        )
        none = {"status": "none", "detail": ""}
        proof = {"status": "pass" if self.closed != "1" else "none", "detail": "", "measured": {"claims": 1}}
        marks = {"symbolic": proof, "enclosed": none, "numeric": numeric, "measured": none}
        return {"key": self.key, "verdict": verdict, "message": message, "marks": marks}


LAMBDA = "(sqrt(1 + 1 / a**2) - 1) / 2"


equations: dict[str, Equation] = {}
for one in (
    Equation("geometry.area", "Projected area", (35, 36), "heitz2014", r"\int D(\omega_m)\, d\omega_m = 1", "1", "1"),
    Equation("visibility.G1", "masking", (39,), "smith1967; heitz2014", r"G_1 = \frac{1}{1 + \Lambda}", "a", "a"),
    Equation("visibility.Lambda", "Lambda of GGX", (62, 63), "heitz2014, eq. 72",
             r"\Lambda(a) = \frac{-1 + \sqrt{1 + \frac{1}{a^{2}}}}{2}", LAMBDA, LAMBDA),
):  # fmt: skip
    equations[one.key] = one
