import importlib.util, numpy as np

spec = importlib.util.spec_from_file_location("old_reading", "/tmp/reading_before.py")
old = importlib.util.module_from_spec(spec)
import sys

sys.modules["old_reading"] = old
spec.loader.exec_module(old)
from bozzetto_polyhedron.rounds.reading import read
from tests.plugins.polyhedron.test_rounds import ink_of, PARTS
from tests.plugins.polyhedron.hand import CLEAN
from dataclasses import replace, fields, is_dataclass


def flat(x):
    if x is None:
        return None
    if is_dataclass(x):
        return [flat(getattr(x, f.name)) for f in fields(x)]
    if isinstance(x, np.ndarray):
        return x.tolist()
    if isinstance(x, (tuple, list)):
        return [flat(v) for v in x]
    if isinstance(x, frozenset):
        return sorted(x)
    return x


n = 0
for name in sorted(PARTS):
    for seed in range(7400, 7408):
        for j in (0.01, 0.02):
            try:
                ink = ink_of(name, seed, replace(CLEAN, jitter=j))
            except AssertionError:
                continue
            for ev in ("clear", "all"):
                a, b = flat(old.read(list(ink), ev)), flat(read(list(ink), ev))
                n += 1
                assert a == b, (name, seed, j, ev)
print("same", n)
