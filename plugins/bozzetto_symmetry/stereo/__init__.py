"""Two mirrored images of one curve: correspondence, depth, uncertainty. Imports ink and below."""
