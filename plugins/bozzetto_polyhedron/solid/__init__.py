"""Exact planes: solids, sheets and nets."""
