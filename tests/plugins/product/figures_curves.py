"""Figures of ink and trim, against what is asked of them.

python -m tests.plugins.product.figures_curves [--first 5000] [--count 40]
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.geometry import Spline, closest_on_mesh
from bozzetto.ink import (
    distances_to_polyline,
    merge_strokes,
    oversketch_curve,
    stroke_weights,
)
from bozzetto.view import Camera
from bozzetto_product.model.curves import Curve
from bozzetto_product.model.state import ProductState
from bozzetto_product.operations.meetings import splines_of
from bozzetto_product.operations.modify import drawn_over, image_nodes, modify
from bozzetto_product.operations.trim import trim
from bozzetto_product.projection.ink_curve import curve_from_ink
from bozzetto_product.projection.sheet_curve import curve_on_sheet
from bozzetto_product.projection.views import seen_at
from tests.plugins.product.drawn_curves import (
    COURSES,
    SHEET,
    bow,
    drawn,
    grid_network,
    largest_move,
    misses,
    on_canvas,
    one_stroke,
    recorded_clusters,
    rough,
    scaled,
    with_mirror,
    worst_distance,
)

Row = tuple[str, str, str, bool | None]


def order_rows(first: int, count: int) -> Iterator[Row]:
    """Worst distance of a drawn curve with seven control points from what was meant.

    That of the ink itself, in order, is beside it: no curve through the ink is nearer.
    """
    for name, course in COURSES.items():
        found, paper, ink = [], [], []
        for seed in range(first, first + count):
            strokes = drawn(course, seed)
            merged = merge_strokes([one.points for one in strokes], stroke_weights(strokes))
            ink.append(worst_distance(merged.points - (500.0, 450.0), course))
            for order, errors in (("drawn", found), ("principal", paper)):
                sheet = curve_on_sheet(strokes, order=order).spline.sampled(2000)
                errors.append(worst_distance(sheet - (500.0, 450.0), course))
        middle, most = np.median(found), np.percentile(found, 95)
        text = (
            f"{middle:.1f} px median, {most:.1f} p95 (ink {np.median(ink):.1f}, "
            f"{np.percentile(ink, 95):.1f}; the paper's order {np.median(paper):.0f})"
        )
        yield f"{name}, 7 control points, worst distance", text, "≤ 6 px", bool(middle <= 6.0)


def _depth_error(seed: int, kind: str) -> tuple[float, float] | None:
    """Return depth error and bend of a stroke that runs off an ellipsoid, in radii.

    It is meant for a larger one; where the rough shape is nearer or farther as a whole does not
    count.
    """
    random = np.random.default_rng(seed)
    radii = random.uniform(35.0, 65.0, 3)
    grow = random.uniform(1.05, 1.25)
    camera = Camera(kind=kind, eye=(0.0, -600.0, 0.0), height=300.0, viewport=(1200.0, 900.0))
    turn = random.uniform(0.0, 2.0 * np.pi)
    inside = 0.55 * random.uniform() * np.array((np.cos(turn), np.sin(turn)))
    turn += random.uniform(-0.6, 0.6)
    outside = random.uniform(1.02, grow - 0.005) * np.array((np.cos(turn), np.sin(turn)))
    middle = 0.5 * (inside + outside) + random.normal(0.0, 0.1, 2)
    t = np.linspace(0.0, 1.0, 160)[:, None]
    plan = (1 - t) ** 2 * inside + 2 * t * (1 - t) * middle + t**2 * outside
    square = (plan**2).sum(axis=1)
    if (square >= grow**2).any() or (square < 1.0).sum() < 10:
        return None
    meant = np.column_stack(
        (plan[:, 0] * radii[0], -radii[1] * np.sqrt(grow**2 - square), plan[:, 1] * radii[2])
    )
    scene = on_canvas(rough("sphere", tuple(2.0 * radii)))
    got = curve_from_ink([one_stroke(seen_at(camera, meant), camera)], scene).spline
    at = np.linspace(0.0, 1.0, 400)
    places = got.value(at)
    from scipy.spatial import cKDTree

    pixels, wanted = seen_at(camera, places), seen_at(camera, meant)
    near = cKDTree(wanted).query(pixels)[1]
    off = places[:, 1] - meant[near, 1]
    off -= np.median(off[np.argsort(np.linalg.norm(plan[near], axis=1))[:200]])
    bend = np.abs(got.derivative(at, 2)[:, 1]).max()
    return float(np.abs(off).max()) / radii[1], float(bend) / radii[1]


def run_off_rows(first: int, count: int) -> Iterator[Row]:
    """Strokes that run off a template 5 to 25 % too small."""
    for kind in ("orthographic", "perspective"):
        found = [
            one for seed in range(first, first + 5 * count) if (one := _depth_error(seed, kind))
        ]
        error, bend = np.array(found).T
        text = (
            f"{np.median(error):.3f} of a radius median, {np.percentile(error, 95):.2f} p95; "
            f"second derivative {np.median(bend):.1f} ({len(found)} strokes)"
        )
        yield f"Run off the silhouette, {kind}", text, "≤ 0.2", bool(np.median(error) <= 0.2)


def _wave(seed: int) -> Array:
    """Return a random course near the middle of the sheet, px."""
    random = np.random.default_rng(seed)
    begin, end = np.array((600.0, 450.0)) + random.uniform(-220.0, 220.0, (2, 2))
    t = np.linspace(0.0, 1.0, 1000)[:, None]
    across = np.array((begin[1] - end[1], end[0] - begin[0]))
    return begin + t * (end - begin) + random.normal(0.0, 0.2) * across * np.sin(np.pi * t)


def image_rows(first: int, count: int) -> Iterator[Row]:
    """How far images of curves on rough shapes are from their ink, and they from the shapes."""
    eye = Camera(eye=(260.0, -380.0, 240.0), fov_y=30.0)
    for kind in ("box", "cylinder", "sphere", "wedge", "mouse", "bottle", "shoe last"):
        size = {"bottle": (90.0, 90.0, 180.0), "shoe last": (190.0, 80.0, 90.0)}.get(kind, None)
        shape = rough(kind, size) if size else rough(kind)
        scene = on_canvas(shape)
        image, ink, away, said = [], [], [0.0], 0
        for seed in range(first, first + count):
            course = _wave(seed)
            if np.linalg.norm(np.ptp(course, axis=0)) < 60.0:
                continue
            got = curve_from_ink([one_stroke(course, eye)], scene)
            seen = seen_at(eye, got.spline.sampled(800))
            image.append(got.image_error)
            ink.append(worst_distance(seen, course))
            said += bool(got.warnings)
            if not got.warnings:
                away.append(float(closest_on_mesh(shape, got.spline.sampled(200)).distances.max()))
        text = (
            f"image {np.max(image):.2f} px worst, {np.percentile(ink, 95):.2f} p95 from the ink "
            f"({len(image)} strokes, {said} with a warning); the others at most "
            f"{np.max(away):.2f} mm from it"
        )
        yield f"Curves on the {kind}", text, "≤ 1.5 px", bool(np.max(image) <= 1.5)


def recorded_rows(count: int) -> Iterator[Row]:
    """Curves that people drew in many strokes, on a sphere."""
    clusters = recorded_clusters(3 * count)
    if not clusters:
        return
    scene = on_canvas(rough("sphere", (400.0, 400.0, 400.0)))
    eye = Camera(eye=(0.0, -900.0, 0.0), fov_y=30.0)
    image, mean, refused = [], [], 0
    for ink in clusters:
        places = np.vstack(ink)
        size = max(float(np.ptp(places, axis=0).max()), 1e-9)
        middle = 0.5 * (places.max(axis=0) + places.min(axis=0))
        strokes = [one_stroke((600, 450) + 360.0 / size * (one - middle), eye) for one in ink]
        try:
            got = curve_from_ink(strokes, scene)
        except UserError:
            refused += 1
            continue
        image.append(got.image_error)
        seen = seen_at(eye, got.spline.sampled(1000))
        every = np.vstack([stroke.points for stroke in strokes])
        mean.append(distances_to_polyline(every, seen).mean())
    text = (
        f"image {np.max(image):.2f} px worst, ink {np.median(mean):.1f} px off on average "
        f"(median; p95 {np.percentile(mean, 95):.1f}; {len(image)} curves, {refused} refused)"
    )
    yield (
        "Recorded ink of many strokes, 7 control points",
        text,
        "image ≤ 1.5 px",
        bool(np.max(image) <= 1.5),
    )


def modify_rows(first: int, count: int) -> Iterator[Row]:
    """How far the image of a modified curve is from the contour that the strokes pulled."""
    away, grown, inside, held = [], [], [], True
    for seed in range(first, first + count):
        random = np.random.default_rng(seed)
        spline = bow(np.array((-80.0, 10.0, -20.0)), np.array((80.0, -30.0, 30.0)), random)
        spots = seen_at(SHEET, spline.sampled(201))
        low = int(random.integers(10, 80))
        piece = spots[low : low + int(random.integers(50, 110))]
        share = np.linspace(0.0, np.pi, len(piece))
        ink = piece + np.outer(np.sin(share) ** 2, random.normal(0.0, 25.0, 2))
        stroke = one_stroke(ink)
        new = drawn_over(spline, [stroke], held=(True, True))
        _, places, _ = image_nodes(spline, SHEET, None)
        nodes = seen_at(SHEET, places)
        contour = oversketch_curve(nodes, [(stroke.points, stroke.pressure)]).points
        image = seen_at(SHEET, new.sampled(1500))
        middle = contour[20:-20]
        away.append(float(distances_to_polyline(middle, image).max()))
        inside.append(float(np.percentile(distances_to_polyline(ink, image), 95)))
        grown.append(len(new.control_points))
        held &= bool((new.control_points[[0, -1]] == spline.control_points[[0, -1]]).all())
    text = (
        f"{np.max(away):.2f} px worst from the contour, {np.median(inside):.2f} from the ink "
        f"(median of p95); {np.median(grown):.0f} control points; ends held {held}"
    )
    yield "Modify, image", text, "≤ 1 px", bool(np.max(away) <= 1.0 and held)


def trim_rows(first: int, count: int) -> Iterator[Row]:
    """What trim does to sheets whose ends miss one another by up to 2 mm of 100."""
    miss, joined, same, mirror, thousand = 0.0, [], True, True, 0.0
    for seed in range(first, first + count):
        state, corners = grid_network(seed, 1.0)
        done = trim(state, gap=2.5).state
        miss = max(miss, misses(done))
        joined.append(len(done.joints) == len(corners))
        random = np.random.default_rng(seed)
        mixed = replace(
            state, nodes=tuple(state.nodes[k] for k in random.permutation(len(state.nodes)))
        )
        other = splines_of(trim(mixed, gap=2.5).state)
        for name, spline in splines_of(done).items():
            same &= bool((other[name].control_points == spline.control_points).all())
        large = splines_of(trim(scaled(state, lambda x: 1000.0 * x), gap=2500.0).state)
        for name, spline in splines_of(done).items():
            off = np.abs(large[name].control_points / 1000.0 - spline.control_points).max()
            thousand = max(thousand, float(off) / 100.0)
        both = with_mirror(state)
        flipped = scaled(both, lambda x: x * (1.0, -1.0, 1.0))
        one, two = (splines_of(trim(each, gap=2.5).state) for each in (both, flipped))
        for name in one:
            mirror &= bool(
                (one[name].control_points * (1.0, -1.0, 1.0) == two[name].control_points).all()
            )
    yield "Trim: ends of joined curves", f"differ by {miss:g} mm", "==", miss == 0.0
    yield (
        "Trim: sheets with every corner found",
        f"{sum(joined)} of {len(joined)}",
        "all",
        all(joined),
    )
    yield "Trim: order of the curves", "same to the last bit" if same else "differs", "same", same
    text = "same to the last bit" if mirror else "differs"
    yield "Trim: mirror image of a network", text, "same", mirror
    yield "Trim: a thousand times as large", f"{thousand:.1e}", "≤ 1e-9", thousand <= 1e-9


def host_rows(first: int, count: int) -> Iterator[Row]:
    """Whether what ends inside a curve goes along with it."""
    off, kinds = 0.0, True
    for seed in range(first, first + count):
        random = np.random.default_rng(seed)
        host = bow(np.array((-80.0, 0.0, 0.0)), np.array((80.0, 0.0, 0.0)), random)
        foot = host.value([random.uniform(0.25, 0.75)])[0]
        guest = bow(foot + random.normal(0.0, 0.5, 3), np.array((10.0, 60.0, 50.0)), random)
        state = ProductState(nodes=(Curve(id="h", spline=host), Curve(id="g", spline=guest)))
        state = trim(state, gap=3.0).state
        kinds &= len(state.joints) == 1
        spots = seen_at(SHEET, host.sampled(101))[20:80]
        share = np.sin(np.linspace(0.0, np.pi, len(spots)))
        moved = modify(state, [one_stroke(spots + np.outer(share, (0.0, -20.0)))])
        off = max(off, misses(moved), misses(state))
    text = f"differ by {off:g} mm"
    yield "T-joints after their curve was modified", text, "==", off == 0.0 and kinds


def closing_rows(first: int, count: int) -> Iterator[Row]:
    """How far nearly closed curves move, in widths of the gap."""
    worst = 0.0
    for seed in range(first, first + 5 * count):
        random = np.random.default_rng(seed)
        turn = np.linspace(0.0, 2.0 * np.pi - random.uniform(0.02, 0.1), 40)
        points = np.column_stack((50.0 * np.cos(turn), 40.0 * np.sin(turn), 5.0 * np.sin(3 * turn)))
        points[-1] += random.normal(0.0, 1.0, 3)
        spline = Spline.uniform(points)
        gap = float(np.linalg.norm(points[-1] - points[0]))
        state = ProductState(nodes=(Curve(id="c", spline=spline),))
        done = trim(state, gap=1.01 * gap)
        moved = max(largest_move(state, done.state).values())
        worst = max(worst, moved / gap if done.joined else np.inf)
    yield "Nearly closed curves", f"move {worst:.2f} gaps at most", "≤ 3", worst <= 3.0


def main() -> None:
    """Print all figures as a table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--first", type=int, default=5000, help="first seed")
    parser.add_argument("--count", type=int, default=40, help="seeds")
    asked = parser.parse_args()
    first, count = asked.first, asked.count
    print("| figure | measured | asked | kept |\n| --- | --- | --- | --- |")
    start = time.perf_counter()
    for rows in (
        order_rows(first, count),
        run_off_rows(first, count),
        image_rows(first, count),
        recorded_rows(count),
        modify_rows(first, count),
        trim_rows(first, min(count, 10)),
        host_rows(first, count),
        closing_rows(first, count),
    ):
        for name, measured, wanted, kept in rows:
            print(f"| {name} | {measured} | {wanted} | {'yes' if kept else 'NO'} |", flush=True)
    print(f"\nSeeds {first} to {first + count - 1}; {time.perf_counter() - start:.0f} s.")


if __name__ == "__main__":
    main()
