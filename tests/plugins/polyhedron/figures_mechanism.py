"""Figures of the mechanism engine: ``python -m tests.plugins.polyhedron.figures_mechanism``.

Seeds are those that no test uses; times are of the process, on whatever else the machine does.
"""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np

from bozzetto_polyhedron.mechanism.analysis import mobility_of
from bozzetto_polyhedron.mechanism.rotations import rotations_by
from bozzetto_polyhedron.mechanism.stepper import Pull, Stepper
from tests.plugins.polyhedron.known_linkages import as_rods, peaucellier
from tests.plugins.polyhedron.mechanisms import (
    LENGTH,
    MASS,
    bars,
    box_on_ground,
    four_bar,
    linkage,
    plates,
    tensions,
)
from tests.plugins.polyhedron.solid_pieces import box, dropped

FIRST_SEED = 40_000


def energy(rate: int, seconds: float = 10.0) -> tuple[float, float]:
    """Return the largest share of the energy of the fall that is lost or gained, and the last."""
    assembly, motion = plates(2)
    stepper = Stepper(assembly, tolerance=1e-10)
    start, fall = stepper.energy(motion), MASS * 9.81 * 2 * LENGTH
    shares = []
    for _ in range(int(seconds * rate)):
        motion = stepper.advanced(motion, 1.0 / rate)
        shares.append((stepper.energy(motion) - start) / fall)
    return float(np.abs(shares).max()), shares[-1]


def coupler(seconds: float = 5.0) -> float:
    """Return the distance of the coupler point from its closed form, m, over free turning."""
    start = 1.0
    assembly, motion = linkage(start)
    stepper = Stepper(assembly, tolerance=1e-13)
    momenta = np.zeros((3, 3))
    momenta[0, 1] = -0.005
    motion = stepper.settled(replace(motion, momenta=momenta))
    place = four_bar(start)[2] - motion.places[1]
    crank, worst = four_bar(start)[0], 0.0
    for _ in range(int(120 * seconds)):
        motion = stepper.advanced(motion, 1 / 120)
        now = motion.turns[0] @ crank
        seen = motion.places[1] + motion.turns[1] @ place
        worst = max(worst, float(np.abs(seen - four_bar(np.arctan2(now[2], now[0]))[2]).max()))
    return worst


def jerks(count: int, seeds: range) -> float:
    """Return the largest gap, in links, when the pen jerks about at 10 m/s."""
    worst = 0.0
    for seed in seeds:
        assembly, motion = plates(count)
        stepper = Stepper(assembly, damping=0.5, tolerance=0.5e-4 * LENGTH)
        rng = np.random.default_rng(seed)
        target = np.array([count * LENGTH, 0.0, 0.0])
        for _ in range(60):
            target = target + rng.normal(size=3) / np.sqrt(3) * 10.0 / 60.0
            hold = np.array([LENGTH / 2, 0, 0])
            pull = Pull(count - 1, hold, target, 5.0 * count, 0.1, 20 * count * MASS * 9.81)
            motion = stepper.advanced(motion, 1 / 60, pull)
            worst = max(worst, stepper.largest_gap(motion))
    return worst / LENGTH


def frames(count: int) -> tuple[float, float]:
    """Return the median and the 95th percentile of a frame's time, ms, while plates are pulled."""
    assembly, motion = plates(count)
    stepper = Stepper(assembly, damping=1.0, tolerance=8e-5 * LENGTH)
    spent = []
    weight = count * MASS * 9.81
    for frame in range(90):
        sway = 1 - 0.4 * (1 - np.cos(frame / 30)), 0.15 * np.sin(frame / 25)
        target = count * LENGTH * np.array([*sway, 0.3 * (1 - np.cos(frame / 20))])
        hold = np.array([LENGTH / 2, 0, 0])
        began = time.process_time()
        motion = stepper.advanced(
            motion, 1 / 60, Pull(count - 1, hold, target, 5.0 * count, 0.5 * count, 8 * weight)
        )
        spent.append(1e3 * (time.process_time() - began))
    return float(np.median(spent)), float(np.percentile(spent, 95))


def ends(count: int) -> float:
    """Return how far apart the ends are at 30 and at 120 frames a second, in extents."""
    found = []
    for rate in (30, 120):
        assembly, motion = plates(count)
        stepper = Stepper(assembly, damping=1.0)
        for frame in range(rate):
            share = (frame + 1) / rate
            target = count * LENGTH * np.array([1 - 0.5 * share, 0.0, 0.4 * share])
            pull = Pull(count - 1, np.array([LENGTH / 2, 0, 0]), target, 60.0, 1.0, 30.0)
            motion = stepper.advanced(motion, 1 / rate, pull)
        found.append(motion.places)
    return float(np.abs(found[0] - found[1]).max() / (count * LENGTH))


def truss(seeds: range) -> float:
    """Return how far forces are from balance at the joints of random trusses, relative."""
    worst = 0.0
    for seed in seeds:
        rng = np.random.default_rng(seed)
        places = rng.normal(size=(9, 3))
        pairs = [(k, int(j)) for k in range(3, 9) for j in rng.choice(k, 3, replace=False)]
        assembly, motion, free = bars(places, pairs, {0, 1, 2})
        loads = rng.normal(size=(len(free), 3))
        forces = tensions(assembly, motion, loads)
        for number, corner in enumerate(free):
            total = loads[number].copy()
            for (a, b), force in zip(pairs, forces, strict=True):
                if corner in (a, b):
                    along = places[b if corner == a else a] - places[corner]
                    total += force * along / np.linalg.norm(along)
            worst = max(worst, float(np.abs(total).max()) / max(1.0, float(np.abs(forces).max())))
    return worst


def straight_line(frames: int = 120) -> float:
    """Return how far Peaucellier's point is from its line, m, over free turning."""
    known = peaucellier()
    assembly, motion, carriers = as_rods(known)
    stepper = Stepper(assembly, tolerance=1e-13)
    momenta = np.zeros_like(motion.momenta)
    momenta[known.bars.index("cp"), 1] = -2e-2
    motion = stepper.settled(replace(motion, momenta=momenta))
    rod, arm = carriers["q"]
    worst = 0.0
    for _ in range(frames):
        motion = stepper.advanced(motion, 1.0 / 120.0)
        seen = (motion.places[rod] + motion.turns[rod] @ arm)[0]
        worst = max(worst, abs(float(seen) - known.corners["q"][0] / 1e3))
    return worst


def drops(seeds: range) -> tuple[float, float, float, float]:
    """Return the worst of boxes that fall turned by chance, after 2 s: speed, m/s; the largest gain
    of energy in a frame, as a share of the fall; the depth below the ground, m; and ms a frame.
    """
    speed, gain, depth, spent = 0.0, 0.0, 0.0, []
    for seed in seeds:
        turn = np.random.default_rng(seed).normal(size=3)
        assembly, motion = box_on_ground(height=0.25, turn=(turn[0], turn[1], turn[2]))
        stepper, ground = Stepper(assembly), assembly.ground
        energy = fall = stepper.energy(motion)
        for _ in range(120):
            began = time.process_time()
            motion = stepper.advanced(motion, 1.0 / 60.0)
            spent.append(1e3 * (time.process_time() - began))
            now = stepper.energy(motion)
            gain, energy = max(gain, (now - energy) / fall), now
            corners = ground.points @ motion.turns[0].T + motion.places[0]
            depth = max(depth, -float(corners[:, 2].min()))
        speed = max(speed, float(np.abs(motion.velocities).max()))
    return speed, gain, depth, float(np.percentile(spent, 95))


def stacked(seconds: float = 2.0) -> tuple[float, float]:
    """Return how fast two boxes still are that fell on one another, m/s, and ms a frame."""
    size = (100, 60, 40)
    assembly, motion = dropped([box(size), box(size)], [(0, 0, 0.03), (0.02, 0.01, 0.1)])
    stepper, spent = Stepper(assembly), []
    for _ in range(round(60 * seconds)):
        began = time.process_time()
        motion = stepper.advanced(motion, 1.0 / 60.0)
        spent.append(1e3 * (time.process_time() - began))
    return float(np.abs(motion.velocities).max()), float(np.median(spent))


def tumbled(seeds: range) -> tuple[float, list[float]]:
    """Return how still heaps of five boxes are 2 s after they fell, m/s, and ms of every frame."""
    speed, spent = 0.0, []
    for seed in seeds:
        rng = np.random.default_rng(seed)
        bodies = [box(rng.uniform(30.0, 90.0, 3)) for _ in range(5)]
        places = [(*rng.uniform(-0.02, 0.02, 2), 0.08 + 0.11 * k) for k in range(5)]
        assembly, motion = dropped(bodies, places, rotations_by(rng.normal(size=(5, 3))))
        stepper = Stepper(assembly)
        for _ in range(120):
            began = time.process_time()
            motion = stepper.advanced(motion, 1.0 / 60.0)
            spent.append(1e3 * (time.process_time() - began))
        speed = max(speed, float(np.abs(motion.velocities).max()))
    return speed, spent


def passed(seeds: range) -> int:
    """Return how many boxes passed a plate of 2 mm that they were thrown at with 10 m/s.

    They are turned by chance; those that slid off beside its edge did not pass it.
    """
    count = 0
    for seed in seeds:
        rng = np.random.default_rng(seed)
        turn = rotations_by(rng.normal(size=(1, 3)) * 2.0)[0]
        place = (-0.3, *rng.uniform(-0.08, 0.08, 2))
        bodies = [box((20, 16, 12)), box((2, 400, 400))]
        assembly, motion = dropped(bodies, [place, (0, 0, 0)], [turn, np.eye(3)], ground=False)
        stepper = Stepper(replace(assembly, gravity=np.zeros(3)))
        motion = replace(motion, velocities=np.array([[10.0, 0.0, 0.0], [0.0, 0.0, 0.0]]))
        for _ in range(30):
            motion = stepper.advanced(motion, 1.0 / 60.0)
            way = motion.turns[1].T @ (motion.places[0] - motion.places[1])
            if np.abs(way[1:]).max() > 0.2:
                break
            if way[0] > 0.0:
                count += 1
                break
    return count


def row(what: str, value: float, asked: float, digits: str = ".1e") -> None:
    kept = "yes" if value <= asked else "no"
    print(f"| {what} | {value:{digits}} | {asked:g} | {kept} |", flush=True)


def main() -> None:
    """Print the table."""
    print("| | measured | asked | kept |\n|---|---|---|---|")
    largest, last = energy(120)
    row("energy over 10 s undamped at 120 Hz, largest share", largest, 0.06, ".3f")
    row("the same at the end", abs(last), 0.06, ".3f")
    row("four-bar coupler point against its closed form, m", coupler(), 1e-9)
    row("joint gap in links, pen jerks of 10 m/s, 5 plates", jerks(5, range(40_000, 40_003)), 1e-4)
    row("30 against 120 frames a second, end pose", ends(6), 0.01, ".4f")
    row("truss forces, balance at joints", truss(range(40_010, 40_030)), 1e-6)
    degrees = mobility_of(*plates(10)).degrees
    row("freedoms of 10 hinged plates, difference from 10", abs(degrees - 10), 0, "d")
    row("Peaucellier's point from its straight line, m", straight_line(), 1e-9)
    speed, gain, depth, slow = drops(range(40_020, 40_030))
    row("ten dropped boxes after 2 s, fastest, m/s", speed, 1e-3)
    row("the same, largest gain of energy in a frame, share of the fall", gain, 1e-2)
    row("the same, deepest corner below the ground, m", depth, 1e-3)
    row("the same, ms a frame, 95th percentile", slow, 16.0, ".1f")
    speed, spent = tumbled(range(70, 76))
    row("six heaps of five boxes 2 s after they fell, fastest, m/s", speed, 1e-3)
    row("the same, ms a frame, median", float(np.median(spent)), 16.0, ".1f")
    tail = float(np.percentile(spent, 95))
    row("the same, ms a frame, 95th percentile", tail, 16.0, ".1f")
    speed, median = stacked()
    row("a stack of two boxes after 2 s, fastest, m/s", speed, 1e-6)
    row("the same, ms a frame, median", median, 16.0, ".1f")
    row(
        "boxes of 40 that pass a plate of 2 mm, thrown at 10 m/s",
        passed(range(40_040, 40_080)),
        0,
        "d",
    )
    for count in (10, 50, 100):
        median, slow = frames(count)
        row(f"{count} hinged plates, ms a frame, median", median, 16.0, ".1f")
        if count < 100:
            row(f"{count} hinged plates, ms a frame, 95th percentile", slow, 16.0, ".1f")
        else:
            print(f"| {count} hinged plates, ms a frame, 95th percentile | {slow:.1f} | | |")


if __name__ == "__main__":
    main()
