// What is around splits, as `Stars` of rust/lod has it, in as many bindings as it needs.

/// Numbers of each binding.
override STARS: u32 = 0xffffffffu;

/// Of every split where its numbers begin.
@group(3) @binding(0) var<storage, read> starts: array<u32>;
@group(3) @binding(1) var<storage, read> stars: array<u32>;
@group(3) @binding(2) var<storage, read> more_stars: array<u32>;
@group(3) @binding(3) var<storage, read> last_stars: array<u32>;

fn star(place: u32) -> u32 {
    if place < STARS {
        return stars[place];
    }
    let beyond = place - STARS;
    if beyond < STARS {
        return more_stars[beyond];
    }
    return last_stars[beyond - STARS];
}
