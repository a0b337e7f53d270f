"""Cameras from marks: known points in space, and where a picture shows them."""

from __future__ import annotations

from bozzetto.view.calibration.dlt import DirectCamera, Parts, direct_linear_transform
from bozzetto.view.calibration.input_checks import spread_most
from bozzetto.view.calibration.levenberg_marquardt import CROPPED, freedom
from bozzetto.view.calibration.normalization import Framing
from bozzetto.view.calibration.pose import NEAREST, PARAMETERS, Poses
from bozzetto.view.calibration.prediction import Help, Places, most_helpful, predicted
from bozzetto.view.calibration.resection import Resection, resect

__all__ = [
    "CROPPED",
    "NEAREST",
    "PARAMETERS",
    "DirectCamera",
    "Framing",
    "Help",
    "Parts",
    "Places",
    "Poses",
    "Resection",
    "direct_linear_transform",
    "freedom",
    "most_helpful",
    "predicted",
    "resect",
    "spread_most",
]
