//! Catmull-Clark limit surfaces: tiles, patches, evaluation, bounds.
