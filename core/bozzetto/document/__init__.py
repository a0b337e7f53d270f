"""Documents: immutable snapshots, their history, their file, and what survives a crash."""

from __future__ import annotations

from bozzetto.document.model import Document, Model, NamedView, Underlay

__all__ = ["Document", "Model", "NamedView", "Underlay"]
