"""States of earlier versions, in the plain form in which documents keep them."""

from __future__ import annotations

from typing import Any


def with_spots(state: dict[str, Any]) -> dict[str, Any]:
    """Return a state of version 1 with spots for the corners that are held.

    They were places of the drawing, px.
    """
    nodes = [_with_spots(node) for node in state.get("nodes", ())]
    return {**state, "nodes": nodes}


def _with_spots(node: dict[str, Any]) -> dict[str, Any]:
    if not node.get("anchors"):
        return node
    anchors = [{"spot": {"body": node["id"], "corner": corner}} for corner in node["anchors"]]
    return {**node, "anchors": anchors}
