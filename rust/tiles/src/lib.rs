//! Tile heaps, rings and displaced evaluation.
