// import common
// Screen-space foam on a device, as rust/render/src/foam: what its kernels share.

/// Entries of the table of a falloff.
const ENTRIES: u32 = 1025u;
/// What is behind everything.
const FARTHEST_DEPTH: f32 = 3.0e38;

/// The view, the environment and the settings of a picture.
struct FoamLook {
    /// Axes of the camera in the world; the last one is against the direction of view.
    right: vec3<f32>,
    width: u32,
    up: vec3<f32>,
    height: u32,
    back: vec3<f32>,
    is_parallel: u32,
    /// Axes of the environment: upwards, and of longitudes 0 and a quarter turn.
    zenith: vec3<f32>,
    /// Pixels of a metre at a depth of 1 m, or at any depth.
    scale: f32,
    first: vec3<f32>,
    /// Rows of the map of light.
    rows: u32,
    second: vec3<f32>,
    irr_scale: f32,
    shadow_color: vec3<f32>,
    radius: f32,
    near_depth: f32,
    aperture: f32,
    focus: f32,
    eta_max: f32,
    lifetime_n: f32,
    lifetime_m: f32,
    rho_mod: f32,
    rho_exp: f32,
    ao_init_sr_fac: f32,
    ao_sr_inc_fac: f32,
    ao_passes: u32,
    ao_s_dens: f32,
    ao_min_samp: u32,
    ao_max_samp: u32,
    ao_max_occl_dist: f32,
    ao_fluid_opacity: f32,
    ao_solid_opacity: f32,
    ao_hemisphere: u32,
    ao_sh_scale: f32,
    ao_sh_exp: f32,
    ao_sh_offset: f32,
    irradiance_map: u32,
    filter_radius: f32,
}

/// A pixel while particles are drawn.
struct FoamPixel {
    /// Depth of the nearest fragment as `rising` makes it.
    depth: atomic<u32>,
    /// The lowest number of the particles at that depth, and the lowest place on a disc of those of that number.
    id: atomic<u32>,
    key: atomic<u32>,
    /// Thickness in fixed point, in units of 2⁻³², and whole ones.
    low: atomic<u32>,
    high: atomic<u32>,
    /// Of the nearest fragment: the search radius in pixels, and its place on the disc.
    search: f32,
    u: f32,
    v: f32,
}

@group(0) @binding(0) var<storage, read> look: FoamLook;
@group(0) @binding(1) var<storage, read_write> pixels: array<FoamPixel>;
/// Of every pixel the depth of foam, its intensity, and the depths of the fluid and of solids.
@group(0) @binding(2) var<storage, read_write> fronts: array<vec4<f32>>;

/// A number in the order of unsigned integers.
fn rising(value: f32) -> u32 {
    let bits = bitcast<u32>(value);
    return bits ^ select(0x80000000u, 0xffffffffu, (bits >> 31u) == 1u);
}

/// The number that `rising` made one of.
fn falling(bits: u32) -> f32 {
    return bitcast<f32>(bits ^ select(0xffffffffu, 0x80000000u, (bits >> 31u) == 1u));
}

/// A power of a number that is not negative.
fn power(base: f32, exponent: f32) -> f32 {
    if exponent == 0.0 {
        return 1.0;
    }
    return select(0.0, pow(base, exponent), base > 0.0);
}

/// Pixels of a metre at a depth.
fn scale_at(depth: f32) -> f32 {
    if look.is_parallel == 1u {
        return look.scale;
    }
    return look.scale / depth;
}

/// Where a place in eye space is in the picture, in pixels.
fn to_picture(place: vec3<f32>) -> vec2<f32> {
    let scale = scale_at(place.z);
    return vec2(0.5 * f32(look.width) + scale * place.x, 0.5 * f32(look.height) - scale * place.y);
}

/// The unit normal of a place on a disc, to the right, up and towards the camera.
fn normal_of(u: f32, v: f32) -> vec3<f32> {
    return vec3(u, v, sqrt(max(1.0 - u * u - v * v, 0.0)));
}
