"""The kernels of the papers against quadrature, and laws of the fields made from them."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from scipy.integrate import quad

from bozzetto_silhouette.analysis.fidelity import measure
from bozzetto_silhouette.implicit.convolution_field import convolution_field, with_correction
from bozzetto_silhouette.implicit.kernel_sums import summation_of
from bozzetto_silhouette.implicit.kernels import Compact, InversePower, Kernel
from bozzetto_silhouette.inflation.inflation import ConvolutionHeights
from bozzetto_silhouette.inflation.solidify import solidify
from bozzetto_silhouette.model.state import Kernel as KernelName
from bozzetto_silhouette.outline.medial_axis import Skeleton
from bozzetto_silhouette.outline.normalized import SkeletonRule, frame_of
from tests.plugins.silhouette import outlines as o

KERNELS = {
    "cauchy": (InversePower(4, 1.0 / 1.7**2), lambda r2: (1 / 1.7**2 + r2) ** -2, 1e-11),
    "inverse-cubic": (InversePower(3), lambda r2: (1e-12 + r2) ** -1.5, 1e-11),
    "inverse-quartic": (InversePower(4), lambda r2: (1e-12 + r2) ** -2, 1e-11),
    "quartic": (Compact(2, 1.5), lambda r2: max(0.0, 1 - r2 / 2.25) ** 2, 1e-9),
    "sextic": (Compact(3, 1.5), lambda r2: max(0.0, 1 - r2 / 2.25) ** 3, 1e-9),
}


def _one(kernel: Kernel, method: str, a: float, b: float, d2: float) -> tuple[float, float]:
    zeroth, first = getattr(kernel, method)(*(np.array([v]) for v in (a, b, d2)))
    return float(zeroth[0]), float(first[0])


@pytest.mark.parametrize("name", KERNELS)
def test_moments_against_quadrature(name: str) -> None:
    kernel, shape, tolerance = KERNELS[name]
    random = np.random.default_rng(3)
    for _ in range(60):
        p, q, r = random.normal(size=(3, 3))
        w0, w1 = random.uniform(0.2, 0.9, 2)
        length = float(np.linalg.norm(q - p))
        x = float((r - p) @ (q - p)) / length
        d2 = max(float((r - p) @ (r - p)) - x * x, 0.0)
        k = (w1 - w0) / length
        zeroth, first = _one(kernel, "moments", -x, length - x, d2)

        def field(t: float, x: float = x, d2: float = d2, w0: float = w0, k: float = k) -> float:
            return (w0 + k * t) * shape(d2 + (t - x) ** 2)

        # The kernel may have a kink at its reach, and a peak at the foot.
        ends = [x - np.sqrt(max(2.25 - d2, 0.0)), x, x + np.sqrt(max(2.25 - d2, 0.0))]
        stops = [0.0, *sorted(t for t in ends if 0.0 < t < length), length]
        exact = sum(
            quad(field, a, b, epsabs=0, epsrel=1e-12, limit=400)[0]
            for a, b in itertools.pairwise(stops)
        )
        assert (w0 + k * x) * zeroth + k * first == pytest.approx(exact, rel=tolerance, abs=1e-13)


@pytest.mark.parametrize("name", ["cauchy", "inverse-cubic", "inverse-quartic"])
@pytest.mark.parametrize("d2", [0.0, 1e-10, 1e-6, 1e-3, 0.02, 0.04])
def test_points_ahead_of_a_segment_lose_no_digits(name: str, d2: float) -> None:
    kernel, shape, _ = KERNELS[name]
    for a, b in ((1.0, 1.5), (-1.01, -1.0), (1.0, 9.0)):
        exact, _ = quad(lambda s: shape(d2 + s * s), a, b, epsabs=0, epsrel=1e-12)
        assert _one(kernel, "moments", a, b, d2)[0] == pytest.approx(exact, rel=1e-10)


@pytest.mark.parametrize("name", KERNELS)
def test_falls_are_the_derivatives(name: str) -> None:
    kernel, _, _ = KERNELS[name]
    random = np.random.default_rng(5)
    h = 1e-4
    for _ in range(30):
        a = float(random.normal())
        b = a + float(random.uniform(0.05, 1.0))
        d2 = float(random.uniform(0.02, 1.5))
        found = _one(kernel, "falls", a, b, d2)
        ahead, back = (_one(kernel, "moments", a, b, d2 + e) for e in (h, -h))
        for k in (0, 1):
            slope = (ahead[k] - back[k]) / (2 * h)
            assert found[k] == pytest.approx(slope, rel=2e-3, abs=1e-6)


@pytest.mark.parametrize("name", KERNELS)
def test_around_an_endless_line_the_level_is_linear_in_the_squared_distance(name: str) -> None:
    kernel, _, _ = KERNELS[name]
    radius = 0.6
    distance = np.array([0.1, 0.3, 0.6, 0.7, 1.2])
    long = np.full(len(distance), 3e3)
    field, _ = kernel.moments(-long, long, distance**2)
    line = kernel.cylinder(np.array([radius]))
    # Ends at 3000 are not yet the end of the world for the cube.
    level, slope = kernel.level(field / line)
    square = level * kernel.square(np.array([radius]))
    assert square == pytest.approx(radius**2 - distance**2, abs=2e-6)
    assert (slope > 0).all()


def test_an_unfitted_chain_sums_to_the_endless_line() -> None:
    x = np.linspace(-30.0, 30.0, 61)
    nodes = np.column_stack([x, np.zeros(61), np.full(61, 0.4)])
    skeleton = Skeleton(nodes, np.column_stack([np.arange(60), np.arange(1, 61)]))
    xy = np.array([[0.0, 0.4], [0.3, 0.0], [0.21, 0.24]])
    height2 = 0.16 - xy[:, 1] ** 2
    names: list[KernelName] = ["scalis", "cauchy", "inverse-cubic", "inverse-quartic", "sextic"]
    for name in names:
        sums = summation_of(skeleton, name, 1.4, 0.4).over(xy)
        total, fall = sums.total(np.ones(60), height2, slope=True)
        assert total == pytest.approx(np.ones(3), rel=2e-3)
        assert fall is not None
        assert (fall < 0).all()
        assert sums.shares(height2).sum(axis=1) == pytest.approx(total, rel=1e-6)


@pytest.mark.parametrize(
    "name", ["cauchy", "inverse-cubic", "inverse-quartic", "quartic", "sextic"]
)
@pytest.mark.parametrize("rule", ["exact", "paper"])
def test_every_kernel_keeps_the_outline(name: KernelName, rule: SkeletonRule) -> None:
    for outline in ("key", "spider"):
        solid = solidify(
            o.outline(outline), resolution=48, height_model=ConvolutionHeights(1.4, name), rule=rule
        )
        found = measure(solid)
        assert found.topology_ok
        assert found.iou > 0.995
        assert 0.8 < found.thickness_ratio < 1.2


@pytest.mark.parametrize("name", ["cauchy", "inverse-cubic", "sextic"])
def test_heights_are_roots_of_the_field(name: KernelName) -> None:
    frame = frame_of(o.outline("heart"))
    field = convolution_field(frame, kernel=name)
    corrected = with_correction(field, frame.rim)
    xy = frame.axis[frame.axis[:, 2] > 0.3 * frame.axis[:, 2].max(), :2]
    z2 = corrected.heights(xy) ** 2
    assert (z2 > 0).all()
    shift = corrected.correction(xy)

    def level(share: float) -> np.ndarray:
        return field.raw_level(xy, share * z2, shift.radius) + shift.lift

    # Where the guard along the outline has a say the height is above the field's own root.
    assert (level(1.02) < 0).all()
    assert np.mean(level(0.98) > 0) > 0.9
