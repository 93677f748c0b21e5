//! Scene files, physics, frame stepping and caches.
