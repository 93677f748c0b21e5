// The tint that traces of contact give to a surface.

struct TintBlock {
    color: vec3<f32>,
    /// How much a unit of depth adds to its share, and what it has without any.
    per_depth: f32,
    at_once: f32,
    /// The share that a second takes away.
    per_second: f32,
    /// Now, in seconds.
    time: f32,
}

/// The colour of a place whose trace is contact, depth, and the time of the last touch times the contact.
fn tint_over(base: vec3<f32>, trace: vec3<f32>, tint: TintBlock) -> vec3<f32> {
    let contact = trace.x;
    let touched = trace.z / select(1.0, contact, contact > 0.0);
    let deep = min(tint.at_once + trace.y * tint.per_depth, 1.0);
    let fresh = clamp(1.0 - (tint.time - touched) * tint.per_second, 0.0, 1.0);
    return mix(base, tint.color, max(contact, 0.0) * deep * fresh);
}
