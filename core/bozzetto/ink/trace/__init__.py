"""From pictures of paper to strokes: page, threshold, skeleton, junctions, gaps."""
