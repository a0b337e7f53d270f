"""What Open CASCADE makes of a closed body when it is asked for a shell 2 mm outside it."""

from __future__ import annotations

import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path

from bozzetto.exchange.cad.step import write_shapes
from bozzetto.geometry import Brep, Shapes

LEAST_GROWTH, MOST_GROWTH = 0.95, 1.15
"""Growth of a valid offset: what is added, relative to 2 mm times the area."""

SECONDS = 240
"""Longest processor time for one offset; 10 to 20 are usual. The clock does not count, for others
may work beside it."""

OFFSET = """
import resource
import sys
from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.BRepGProp import BRepGProp
from OCP.BRepOffset import BRepOffset_Skin
from OCP.BRepOffsetAPI import BRepOffsetAPI_MakeOffsetShape
from OCP.GeomAbs import GeomAbs_Arc
from OCP.GProp import GProp_GProps
from OCP.STEPControl import STEPControl_Reader
from OCP.TopAbs import TopAbs_FACE, TopAbs_SOLID
from OCP.TopExp import TopExp_Explorer

resource.setrlimit(resource.RLIMIT_CPU, (int(sys.argv[2]), int(sys.argv[2])))

def measured(shape, how):
    found = GProp_GProps()
    how(shape, found)
    return found.Mass()

def middle(shape):
    found = GProp_GProps()
    area(shape, found)
    at = found.CentreOfMass()
    return at.X(), at.Y(), at.Z()

reader = STEPControl_Reader()
reader.ReadFile(sys.argv[1])
reader.TransferRoots()
body = TopExp_Explorer(reader.OneShape(), TopAbs_SOLID).Current()
maker = BRepOffsetAPI_MakeOffsetShape()
maker.PerformByJoin(body, 2.0, 0.01, BRepOffset_Skin, False, False, GeomAbs_Arc)
made = maker.Shape()
volume, area = BRepGProp.VolumeProperties_s, BRepGProp.SurfaceProperties_s
grown = measured(made, volume) - measured(body, volume)
whole = BRepCheck_Analyzer(made)
faces = TopExp_Explorer(made, TopAbs_FACE)
while faces.More():
    if not BRepCheck_Analyzer(faces.Current()).IsValid():
        print("spoilt", *middle(faces.Current()))
    faces.Next()
print(maker.IsDone(), whole.IsValid(), grown / (2.0 * measured(body, area)))
"""
"""Offsets the first solid of a STEP file by 2 mm, and says which faces of it are spoilt, whether
it is done and valid, and its growth relative to 2 mm times the area."""


@dataclass(frozen=True)
class Offset:
    """What came of an offset.

    Attributes
    ----------
    done, valid : bool
        Whether there is one, and whether Open CASCADE's own check finds it valid.
    growth : float
        What was added, relative to 2 mm times the area.
    spoilt : tuple of (float, float, float)
        Middles of the faces that are not valid by themselves, mm.
    """

    done: bool
    valid: bool
    growth: float
    spoilt: tuple[tuple[float, float, float], ...] = ()

    @property
    def is_sound(self) -> bool:
        """Whether it can be used."""
        return self.done and self.valid and LEAST_GROWTH < self.growth < MOST_GROWTH


def offset_by_open_cascade(body: Brep, python: str) -> Offset:
    """Return what comes of a closed body that is offset outward by 2 mm.

    Parameters
    ----------
    body : Brep
        The closed body.
    python : str
        A Python that has Open CASCADE.
    """
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "body.step"
        path.write_bytes(write_shapes(Shapes(breps=(body,))))
        try:
            told = subprocess.run(
                [python, "-c", OFFSET, str(path), str(SECONDS)],
                capture_output=True,
                text=True,
                check=True,
            ).stdout.splitlines()
        except subprocess.CalledProcessError:
            return Offset(False, False, 0.0)
    done, valid, growth = told[-1].split()
    rows = [line.split()[1:] for line in told if line.startswith("spoilt ")]
    spoilt = tuple((float(x), float(y), float(z)) for x, y, z in rows)
    return Offset(done == "True", valid == "True", float(growth), spoilt)
