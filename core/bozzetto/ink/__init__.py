"""Ink: strokes as they were drawn, and the plane-curve tools that every modeler shares."""

from __future__ import annotations

from typing import TYPE_CHECKING

from bozzetto.lazy_names import lazy_names

if TYPE_CHECKING:
    from bozzetto.ink.checked_points import FARTHEST as FARTHEST
    from bozzetto.ink.checked_points import is_on_sheet as is_on_sheet
    from bozzetto.ink.checked_points import places_on_sheet as places_on_sheet
    from bozzetto.ink.curves.closing import END_SHARE as END_SHARE
    from bozzetto.ink.curves.closing import close_stroke as close_stroke
    from bozzetto.ink.curves.closing import end_gap as end_gap
    from bozzetto.ink.curves.closing import is_closed_gesture as is_closed_gesture
    from bozzetto.ink.curves.closing import signed_area as signed_area
    from bozzetto.ink.curves.intersections import Crossings as Crossings
    from bozzetto.ink.curves.intersections import crossings as crossings
    from bozzetto.ink.curves.intersections import self_crossings as self_crossings
    from bozzetto.ink.curves.nearest import Nearest as Nearest
    from bozzetto.ink.curves.nearest import distances_to_polyline as distances_to_polyline
    from bozzetto.ink.curves.nearest import nearest_curve as nearest_curve
    from bozzetto.ink.curves.noise_estimate import sample_noise as sample_noise
    from bozzetto.ink.curves.preprocess import PreparedCurve as PreparedCurve
    from bozzetto.ink.curves.preprocess import prepare_curve as prepare_curve
    from bozzetto.ink.curves.resample import arc_length as arc_length
    from bozzetto.ink.curves.resample import distinct as distinct
    from bozzetto.ink.curves.resample import points_along as points_along
    from bozzetto.ink.curves.resample import resample as resample
    from bozzetto.ink.curves.resample import steps_along as steps_along
    from bozzetto.ink.curves.smooth import smooth as smooth
    from bozzetto.ink.curves.spline_fit import SplineFit as SplineFit
    from bozzetto.ink.curves.spline_fit import fit_spline as fit_spline
    from bozzetto.ink.drawing import Drawing as Drawing
    from bozzetto.ink.file_values import PIXELS as PIXELS
    from bozzetto.ink.file_values import PLANE as PLANE
    from bozzetto.ink.file_values import SPACE as SPACE
    from bozzetto.ink.file_values import a_list as a_list
    from bozzetto.ink.file_values import a_number as a_number
    from bozzetto.ink.file_values import a_point as a_point
    from bozzetto.ink.file_values import an_object as an_object
    from bozzetto.ink.file_values import point_rows as point_rows
    from bozzetto.ink.merge.merge import MergedStrokes as MergedStrokes
    from bozzetto.ink.merge.merge import merge_strokes as merge_strokes
    from bozzetto.ink.merge.weights import stroke_weights as stroke_weights
    from bozzetto.ink.oversketch.contour_nodes import contour_nodes as contour_nodes
    from bozzetto.ink.oversketch.displacement import displaced_spline as displaced_spline
    from bozzetto.ink.oversketch.displacement import held_solution as held_solution
    from bozzetto.ink.oversketch.displacement import spline_weights as spline_weights
    from bozzetto.ink.oversketch.lift import lift_curve as lift_curve
    from bozzetto.ink.oversketch.ordered_feet import FEET_LAPS as FEET_LAPS
    from bozzetto.ink.oversketch.ordered_feet import ordered_feet as ordered_feet
    from bozzetto.ink.oversketch.snake import DEFAULT_FORCES as DEFAULT_FORCES
    from bozzetto.ink.oversketch.snake import Oversketched as Oversketched
    from bozzetto.ink.oversketch.snake import SnakeForces as SnakeForces
    from bozzetto.ink.oversketch.snake import oversketch_curve as oversketch_curve
    from bozzetto.ink.same_view import SAME_VIEW as SAME_VIEW
    from bozzetto.ink.same_view import carried_places as carried_places
    from bozzetto.ink.same_view import drawn_at as drawn_at
    from bozzetto.ink.same_view import is_one_view as is_one_view
    from bozzetto.ink.same_view import on_canvas as on_canvas
    from bozzetto.ink.same_view import on_sheet_of as on_sheet_of
    from bozzetto.ink.stroke import Stroke as Stroke
    from bozzetto.ink.stroke import Strokes as Strokes
else:
    __getattr__, __all__ = lazy_names(
        __name__,
        {
            "bozzetto.ink.checked_points": "FARTHEST is_on_sheet places_on_sheet",
            "bozzetto.ink.curves.closing": "END_SHARE close_stroke end_gap is_closed_gesture "
            "signed_area",
            "bozzetto.ink.curves.intersections": "Crossings crossings self_crossings",
            "bozzetto.ink.curves.nearest": "Nearest distances_to_polyline nearest_curve",
            "bozzetto.ink.curves.noise_estimate": "sample_noise",
            "bozzetto.ink.curves.preprocess": "PreparedCurve prepare_curve",
            "bozzetto.ink.curves.resample": "arc_length distinct points_along resample steps_along",
            "bozzetto.ink.curves.smooth": "smooth",
            "bozzetto.ink.curves.spline_fit": "SplineFit fit_spline",
            "bozzetto.ink.drawing": "Drawing",
            "bozzetto.ink.file_values": "PIXELS PLANE SPACE a_list a_number a_point an_object "
            "point_rows",
            "bozzetto.ink.merge.merge": "MergedStrokes merge_strokes",
            "bozzetto.ink.merge.weights": "stroke_weights",
            "bozzetto.ink.oversketch.contour_nodes": "contour_nodes",
            "bozzetto.ink.oversketch.displacement": "displaced_spline held_solution spline_weights",
            "bozzetto.ink.oversketch.lift": "lift_curve",
            "bozzetto.ink.oversketch.ordered_feet": "FEET_LAPS ordered_feet",
            "bozzetto.ink.oversketch.snake": "DEFAULT_FORCES Oversketched SnakeForces "
            "oversketch_curve",
            "bozzetto.ink.same_view": "SAME_VIEW carried_places drawn_at is_one_view "
            "on_canvas on_sheet_of",
            "bozzetto.ink.stroke": "Stroke Strokes",
        },
    )
