/* Relievo: foam in screen space.
 *
 * Particles of spray, foam and bubbles are drawn over a finished picture of any renderer (Akinci, Dippel, Akinci, Teschner
 * 2013, "Screen Space Foam Rendering"). The host adds particles in chunks of any size and order, then shades them and
 * takes the layers, or the picture with the foam over it. Results do not depend on the chunks, their order or threads.
 *
 * The graphics device of the context draws, where it has one: 999 of 1,000 pixels of the picture are then within 1/255 of
 * the processor's. The processor draws where the device is lost already or has no room when the foam is made; the log says
 * so. Where the device is lost later, calls on the foam fail with RLV_ERROR_DEVICE, and foam that is made after that is the
 * processor's. */
#ifndef RELIEVO_FOAM_H
#define RELIEVO_FOAM_H

#include "relievo/context.h"
#include "relievo/parameter.h"

typedef struct RlvFoam {
    uint64_t id;
} RlvFoam;

typedef enum RlvFoamKind {
    RLV_FOAM_SPRAY = 0,  /* flies through air */
    RLV_FOAM_FLOAT = 1,  /* floats on the surface */
    RLV_FOAM_BUBBLE = 2  /* rises within the fluid */
} RlvFoamKind;

/* How foam is rendered, with the names of the paper. rlv_foam_params has ranges, units and defaults of every field. */
typedef struct RlvFoamSettings {
    uint32_t struct_size;
    float radius; /* radius r of a particle before it is varied by its number; not in the paper, m */
    float near_depth; /* particles nearer to the camera are left out; not in the paper, m */
    float spray_n; /* exponent n of the falloff of spray */
    float spray_m; /* exponent m of the falloff of spray */
    float foam_n; /* exponent n of the falloff of surface foam */
    float foam_m; /* exponent m of the falloff of surface foam */
    float bubble_n; /* exponent n of the falloff of bubbles, which is inverted */
    float bubble_m; /* exponent m of the falloff of bubbles, which is inverted */
    float lifetime_n; /* exponent n of the falloff by the share of a lifetime */
    float lifetime_m; /* exponent m of the falloff by the share of a lifetime */
    float eta_max; /* distance η_max behind the surface of the fluid at which particles are invisible; the paper has no value, m */
    float eta_n; /* exponent η_n of the attenuation within the fluid; the paper has no value */
    float eta_m; /* exponent η_m of the attenuation within the fluid; the paper has no value */
    float rho_mod; /* the power ρ_exp of the thickness that has half of the greatest intensity (ρ_mod) */
    float rho_exp; /* exponent ρ_exp of the intensity */
    float ao_init_sr_fac; /* search radius of the first pass of occlusion (AOInitSRFac), as a factor of that of the particle */
    float ao_sr_inc_fac; /* what each further pass adds to that factor (AOSRIncFac) */
    uint32_t ao_passes; /* passes of occlusion (AO#Passes) */
    float ao_s_dens; /* samples in a cubic pixel (AOSDens) */
    uint32_t ao_min_samp; /* samples of a pass at least (AO#MinSamp) */
    uint32_t ao_max_samp; /* samples of a pass at most (AO#MaxSamp) */
    float ao_max_occl_dist; /* distance beyond which nothing occludes (AOMaxOcclDist), m */
    float ao_fluid_opacity; /* opacity of the fluid's surface as an occluder; the paper takes that of the scene */
    float ao_solid_opacity; /* opacity of solids as occluders; the paper takes that of the scene */
    uint32_t ao_hemisphere; /* whether samples of occlusion lie on the outer side of the surface alone; the paper has both sides */
    float ao_sh_scale; /* factor of occlusion in shadows (AOShScale) */
    float ao_sh_exp; /* exponent of shadows (AOShExp) */
    float ao_sh_offset; /* what is added to shadows (AOShOffset) */
    float shadow_red; /* red part of the colour of shadows (CShadowColor) */
    float shadow_green; /* green part of the colour of shadows */
    float shadow_blue; /* blue part of the colour of shadows */
    uint32_t irradiance_map; /* whether irradiance is looked up in a map made once, as the paper suggests, in place of a sum for each pixel */
    float irr_scale; /* factor of irradiance (CIrrScale); the paper has no value */
    float filter; /* radius of the filter of shadows and irradiance, as a factor of the first search radius */
    float aperture; /* diameter of the lens, which blurs particles before and behind the distance of focus; 0 for a pinhole; not in the paper, m */
    float focus; /* depth at which particles are sharp; not in the paper, m */
    float shutter; /* seconds that the shutter is open, during which particles move by their velocities; 0 for still particles; not in the paper, s */
    uint32_t shutter_samples; /* places at which a moving particle is drawn; not in the paper */
} RlvFoamSettings;

#define RLV_FOAM_SETTINGS_INIT \
    {sizeof(RlvFoamSettings), 0.01f, 0.05f, 1.5f, 1.0f, 2.25f, 1.0f, 2.0f, 1.0f, 2.0f, 0.4f, 0.5f, 1.0f, 2.0f, \
     3.0f, 1.25f, 1.0f, 7.0f, 3, 0.5f, 16, 512, 5.0f, 0.5f, 1.0f, 1, 1.0f, 1.5f, -0.05f, 0.0f, 0.0f, 0.2f, 1, \
     1.0f, 1.5f, 0.0f, 10.0f, 0.0f, 8}

/* From where foam is seen, and what stands about it. Depths are metres along the direction of view, as many as there are
 * pixels, row after row from the top; what is not finite or not above 0 counts as nothing there. */
typedef struct RlvFoamView {
    uint32_t struct_size;
    uint32_t width;      /* pixels in a row */
    uint32_t height;     /* rows */
    uint32_t reserved;   /* 0 */
    double eye[3];       /* position of the camera */
    double target[3];    /* where it looks */
    double up[3];        /* the direction that is up in the picture */
    double fov;          /* vertical field of view, rad */
    double orthographic; /* metres that the picture of an orthographic camera is high; 0 for a perspective one */
    const float *solids; /* depths of solids, which hide foam, or NULL */
    const float *fluid;  /* depths of the surface of the fluid, behind which foam fades, or NULL */
} RlvFoamView;

#define RLV_FOAM_VIEW_INIT {sizeof(RlvFoamView), 0, 0, 0, {0, 0, 0}, {0, 0, 0}, {0, 0, 1}, 0.6, 0, NULL, NULL}

/* Particles. Strides are in bytes, 0 for packed. */
typedef struct RlvFoamParticles {
    uint32_t struct_size;
    uint32_t reserved; /* 0 */
    size_t count;
    const float *positions; /* three floats each, metres */
    size_t position_stride;
    const uint32_t *ids; /* on which sizes depend; NULL for 0, 1, 2 and so on */
    size_t id_stride;
    const uint32_t *kinds; /* RlvFoamKind; NULL if all float */
    size_t kind_stride;
    const float *lives; /* shares of their lives that have passed, 0 to 1; NULL for 0 */
    size_t life_stride;
    const float *velocities; /* three floats each, m/s, by which particles move while the shutter is open; NULL for rest */
    size_t velocity_stride;
} RlvFoamParticles;

#define RLV_FOAM_PARTICLES_INIT {sizeof(RlvFoamParticles), 0, 0, NULL, 0, NULL, 0, NULL, 0, NULL, 0, NULL, 0}

/* The light around as a picture by latitude and longitude, the top row upwards, in scene-linear Rec.709. */
typedef struct RlvFoamLight {
    uint32_t struct_size;
    uint32_t width;        /* texels in a row, twice as many as rows */
    uint32_t height;       /* rows */
    float up[3];           /* the direction of the top row */
    const float *radiance; /* three floats a texel; infinite ones count as 65504 */
} RlvFoamLight;

#define RLV_FOAM_LIGHT_INIT {sizeof(RlvFoamLight), 0, 0, {0, 0, 1}, NULL}

/* Arrays that rlv_foam_get writes layers to. Each is packed, has an element for each pixel, row after row from the top, and
 * may be NULL: that layer is left out. */
typedef struct RlvFoamLayers {
    uint32_t struct_size;
    uint32_t reserved; /* 0 */
    float *intensity;  /* 0 to 1 */
    float *thickness;
    float *depth;      /* of the nearest particle, metres; infinite where there is none */
    float *normal;     /* three floats, of unit length in the world; zero where there is none */
    float *occlusion;  /* 0 to 1 */
    float *irradiance; /* three floats; 1 in white light of radiance 1 */
} RlvFoamLayers;

#define RLV_FOAM_LAYERS_INIT {sizeof(RlvFoamLayers), 0, NULL, NULL, NULL, NULL, NULL, NULL}

/* The fields of RlvFoamSettings in order: a table that lives as long as the process, and its length. No failure of its
 * own. */
RLV_API RlvResult rlv_foam_params(const RlvParameter **params, size_t *count);

/* Makes a picture without foam; settings may be NULL for the defaults. Fails if a number is out of range, the camera has no
 * direction of view, or the picture does not fit the memory limit of the context. A picture of the processor takes 64 bytes a pixel; one of a
 * device takes 112, and 64 on the device. */
RLV_API RlvResult rlv_foam_create(RlvContext context, const RlvFoamView *view, const RlvFoamSettings *settings,
                                  RlvFoam *out);

RLV_API RlvResult rlv_foam_retain(RlvFoam foam);
RLV_API RlvResult rlv_foam_release(RlvFoam foam);

/* Adds particles. Fails, and adds none, if a number is not finite or a kind is unknown, or after rlv_foam_shade. */
RLV_API RlvResult rlv_foam_add(RlvFoam foam, const RlvFoamParticles *particles);

/* Makes the layers of all particles; no more can be added afterwards. A light of NULL is white from everywhere. Fails, and
 * changes nothing, if a radiance is negative or not a number, or the light is not twice as wide as high; after
 * RLV_ERROR_CANCELLED the particles are gone. */
RLV_API RlvResult rlv_foam_shade(RlvFoam foam, const RlvFoamLight *light, RlvProgress progress, void *user);

/* Writes layers. Fails before rlv_foam_shade. */
RLV_API RlvResult rlv_foam_get(RlvFoam foam, const RlvFoamLayers *layers);

/* Lays the foam over a picture of 3 or 4 channels, row after row from the top, which may be written in place: picture may
 * be background. A fourth channel is copied. Fails before rlv_foam_shade. */
RLV_API RlvResult rlv_foam_composite(RlvFoam foam, const float *background, uint32_t channels, float *picture);

#endif
