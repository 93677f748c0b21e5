//! Reference ray caster, images and image comparison.
