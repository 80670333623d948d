"""The albedo by another sum: rows of slopes parallel to the view, each halved until it is known.

Nothing is shared with the library's rule but D, G2 and F: not the coordinates, not how errors are told, not where it is cut.
Whatever may have a kink there is a polynomial along a row: it is found from a few values, and its roots by their matrix.
"""

from __future__ import annotations

from collections.abc import Callable

import microfacet as mf
import numpy as np

TOLERANCE = 1e-11
RULES = (15, 11, 8)  # Gauss nodes of an interval, and of the two rules that tell its error: one may agree by chance


def _nodes() -> tuple[np.ndarray, np.ndarray]:
    """All nodes, and the weights of the first rule and of its differences from the others."""
    rules = [np.polynomial.legendre.leggauss(count) for count in RULES]
    ends = np.cumsum([0, *RULES])
    weights = np.zeros((ends[-1], len(RULES)))
    for k, (_, weight) in enumerate(rules):
        weights[ends[k] : ends[k + 1], k] = weight
    return np.concatenate([nodes for nodes, _ in rules]), np.stack([weights[:, 0], *(weights[:, 0] - w for w in weights.T[1:])])


NODES, WEIGHTS = _nodes()


def halved(
    function: Callable[[np.ndarray, np.ndarray], np.ndarray],
    owner: np.ndarray,
    low: np.ndarray,
    high: np.ndarray,
    goal: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """Integrals of function(owner, places), one for each owner of intervals, and their errors; goal: of its intervals."""
    count = int(owner.max()) + 1
    total, off = np.zeros(count), np.zeros(count)
    for turn in range(60):
        half = ((high - low) / 2)[:, None]
        values = function(np.repeat(owner[:, None], len(NODES), 1), ((low + high) / 2)[:, None] + half * NODES) * half
        value, *apart = WEIGHTS @ values.T
        error = abs(np.array(apart)).max(axis=0)
        done = (error <= goal[owner]) | (error <= 1e-13 * abs(value)) | (turn == 59)
        total += np.bincount(owner[done], value[done], count)
        off += np.bincount(owner[done], error[done], count)
        if done.all():
            return total, off
        owner, low, high = owner[~done], low[~done], high[~done]
        middle = (low + high) / 2
        owner = np.concatenate([owner, owner])
        low, high = np.concatenate([low, middle]), np.concatenate([middle, high])
    raise AssertionError("not reached")


class Rows:
    """The rows of one view: u = q t + r n in slopes over the scales, t along the view; q and r are hyperbolic sines."""

    def __init__(self, brdf: mf.Microfacet, wo: np.ndarray, size: float) -> None:
        self.brdf, self.wo, self.size = brdf, wo, size
        self.alpha = np.array(brdf.model.ndf.slope_scale)
        slope = self.alpha * wo[:2] / wo[2]
        self.T = float(np.hypot(*slope))
        t = slope / self.T if self.T > 0 else np.array([1.0, 0.0])
        self.t, self.n = self.alpha * t, self.alpha * np.array([-t[1], t[0]])
        self.tt, self.tn, self.nn = self.t @ self.t, self.t @ self.n, self.n @ self.n
        self.off = 0.0

    def ends(self) -> tuple[float, float]:
        """The r of the first and the last row: where t.t q^2 + 2 (t.n r + T) q + n.n r^2 = 1 has a double root."""
        a = (self.alpha.prod()) ** 2
        b, c = self.tn * self.T, self.T**2 + self.tt
        root = np.sqrt(b * b + a * c)
        return (-c / (b + root) if b > 0 else (b - root) / a), (c / (root - b) if b < 0 else (b + root) / a)

    def inside(self, r: np.ndarray, q: np.ndarray) -> np.ndarray:
        """F G2 <o, m> D over o_z m_z^4, zero outside."""
        x, y = q * self.t[0] + r * self.n[0], q * self.t[1] + r * self.n[1]
        z = 1 / np.sqrt(1 + x * x + y * y)
        m = np.stack([-x * z, -y * z, z], axis=-1)
        shown = 1 - q * self.T
        rise = 1 - 2 * self.T * q - (x * x + y * y)
        c = np.clip(self.wo[2] * z * shown, 0, 1)
        wi = 2 * c[..., None] * m - self.wo
        wi[..., 2] = np.clip(self.wo[2] * z * z * rise, 1e-300, 1)
        model = self.brdf.model
        found = self.brdf.fresnel.F(c) * model.G2(self.wo, wi, m) * shown * model.ndf.D(m) * z**4
        return np.where((rise > 0) & (shown > 0), found, 0)

    def row(self, r: np.ndarray) -> np.ndarray:
        """The integral along rows."""
        flat = r.ravel()
        b, c = self.tn * flat + self.T, self.nn * flat**2 - 1
        root = np.sqrt(np.maximum(b * b - self.tt * c, 0))
        with np.errstate(invalid="ignore", divide="ignore"):
            low = np.where(b >= 0, -(b + root) / self.tt, c / (root - b))
            high = np.where(b >= 0, -c / (b + root), (root - b) / self.tt)
        width = np.sqrt(1 + flat * flat)
        low, high = np.arcsinh(low / width), np.arcsinh(high / width)
        kept = np.flatnonzero(high > low)
        if not len(kept):
            return np.zeros(r.shape)
        cuts = np.sort(
            np.clip(np.arcsinh(self.cuts(flat[kept]) / width[kept, None]), low[kept, None], high[kept, None]), axis=1
        )
        ends = np.concatenate([low[kept, None], cuts, high[kept, None]], axis=1)
        owner = np.repeat(kept[:, None], ends.shape[1] - 1, 1).ravel()
        start, stop = ends[:, :-1].ravel(), ends[:, 1:].ravel()
        long = stop > start
        owner, start, stop = owner[long], start[long], stop[long]

        def along(owner: np.ndarray, s: np.ndarray) -> np.ndarray:
            q = np.sinh(s) * width[owner]
            return self.inside(flat[owner], q) * np.cosh(s) * width[owner]

        value, off = halved(along, owner, start, stop, self.size * TOLERANCE / width)
        out = np.zeros(len(flat))
        out[: len(value)] = value
        self.off = max(self.off, float((off * width[: len(off)]).max()))
        return out.reshape(r.shape)

    def cuts(self, r: np.ndarray) -> np.ndarray:
        """Along each row, real parts of the roots of what changes sign at a kink, and where the row is nearest to slope 0."""
        places = np.cos(np.pi * (np.arange(5) + 0.5) / 5)
        scale = 1 / (np.sqrt(self.tt) + self.T) + 0 * r
        values = self.signs(r[:, None], scale[:, None] * places)
        powers = np.moveaxis(values, 0, -2) @ np.linalg.inv(np.vander(places, 5, increasing=True)).T
        powers /= abs(powers).max(axis=-1, keepdims=True) + 1e-300
        lead = np.where(abs(powers[..., 4:]) > 1e-13, powers[..., 4:], 1e-13)
        matrix = np.zeros((*powers.shape[:-1], 4, 4))
        matrix[..., np.arange(1, 4), np.arange(3)] = 1
        matrix[..., :, 3] = -powers[..., :4] / lead
        roots = np.linalg.eigvals(matrix).real
        return np.concatenate([roots.reshape(len(r), -1) * scale[:, None], 0 * r[:, None]], axis=1)

    def signs(self, r: np.ndarray, q: np.ndarray) -> np.ndarray:
        """Polynomials along rows whose signs change where the integrand has a kink, or may change fast."""
        ox, oy, oz = self.wo
        x, y = q * self.t[0] + r * self.n[0], q * self.t[1] + r * self.n[1]
        square, shown = 1 + x * x + y * y, 1 - q * self.T
        ix, iy, iz = -2 * shown * x - ox / oz * square, -2 * shown * y - oy / oz * square, 2 * shown - square
        ax, ay = self.alpha
        index, absorption = (*self.brdf.fresnel.parameters, 0.0)[:2] if len(self.brdf.fresnel.parameters) else (1.0, 0.0)
        total = oz * oz * shown**2 - (1 - index**2 + absorption**2) * square
        cavity = [shown - 2, 4 * shown - square * (2 + shown), shown - square]
        smith = [(ax * ix) ** 2 + (ay * iy) ** 2 - self.T**2 * iz**2, x * oy - y * ox]
        return np.stack(np.broadcast_arrays(total, *cavity, *smith, ix, iy))

    def total(self) -> tuple[float, float]:
        low, high = (np.arcsinh(end) for end in self.ends())

        def across(owner: np.ndarray, s: np.ndarray) -> np.ndarray:
            r = np.sinh(s)
            return self.row(r) * np.cosh(s)

        zero = np.zeros(2, int)
        value, off = halved(across, zero, np.array([low, 0.0]), np.array([0.0, high]), np.array([TOLERANCE * self.size]))
        both = self.alpha.prod() * np.array([value[0], off[0] + (high - low) * self.off])
        return float(both[0]), float(both[1])
