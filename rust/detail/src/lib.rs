//! Imprints from colliding objects.
