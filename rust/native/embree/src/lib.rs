//! Embree reached through a table of functions loaded at run time.
