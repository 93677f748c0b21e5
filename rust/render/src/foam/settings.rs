//! The settings of screen-space foam, with the names and the values of Akinci et al. 2013.

use relievo_core::parameter::Switch;

relievo_core::parameters! {
    /// How foam is rendered. Where the paper gives no value, the help says so.
    pub struct FoamSettings {
        /// Radius r of a particle before it is varied by its number; not in the paper.
        radius: f32 = 0.01, 0.000001..=1000, "m";
        /// Particles nearer to the camera are left out; not in the paper.
        near_depth: f32 = 0.05, 0.0001..=1000, "m";
        /// Exponent n of the falloff of spray.
        spray_n: f32 = 1.5, 0..=64, "";
        /// Exponent m of the falloff of spray.
        spray_m: f32 = 1.0, 0..=64, "";
        /// Exponent n of the falloff of surface foam.
        foam_n: f32 = 2.25, 0..=64, "";
        /// Exponent m of the falloff of surface foam.
        foam_m: f32 = 1.0, 0..=64, "";
        /// Exponent n of the falloff of bubbles, which is inverted.
        bubble_n: f32 = 2.0, 0..=64, "";
        /// Exponent m of the falloff of bubbles, which is inverted.
        bubble_m: f32 = 1.0, 0..=64, "";
        /// Exponent n of the falloff by the share of a lifetime.
        lifetime_n: f32 = 2.0, 0..=64, "";
        /// Exponent m of the falloff by the share of a lifetime.
        lifetime_m: f32 = 0.4, 0..=64, "";
        /// Distance η_max behind the surface of the fluid at which particles are invisible; the paper has no value.
        eta_max: f32 = 0.5, 0.000001..=100000, "m";
        /// Exponent η_n of the attenuation within the fluid; the paper has no value.
        eta_n: f32 = 1.0, 0..=64, "";
        /// Exponent η_m of the attenuation within the fluid; the paper has no value.
        eta_m: f32 = 2.0, 0..=64, "";
        /// The power ρ_exp of the thickness that has half of the greatest intensity (ρ_mod).
        rho_mod: f32 = 3.0, 0.000001..=1000000, "";
        /// Exponent ρ_exp of the intensity.
        rho_exp: f32 = 1.25, 0.01..=64, "";
        /// Search radius of the first pass of occlusion (AOInitSRFac), as a factor of that of the particle.
        ao_init_sr_fac: f32 = 1.0, 0.01..=1000, "";
        /// What each further pass adds to that factor (AOSRIncFac).
        ao_sr_inc_fac: f32 = 7.0, 0..=1000, "";
        /// Passes of occlusion (AO#Passes).
        ao_passes: u32 = 3, 0..=16, "";
        /// Samples in a cubic pixel (AOSDens).
        ao_s_dens: f32 = 0.5, 0.000001..=1000, "";
        /// Samples of a pass at least (AO#MinSamp).
        ao_min_samp: u32 = 16, 1..=4096, "";
        /// Samples of a pass at most (AO#MaxSamp).
        ao_max_samp: u32 = 512, 1..=4096, "";
        /// Distance beyond which nothing occludes (AOMaxOcclDist).
        ao_max_occl_dist: f32 = 5.0, 0.000001..=1000000, "m";
        /// Opacity of the fluid's surface as an occluder; the paper takes that of the scene.
        ao_fluid_opacity: f32 = 0.5, 0..=1, "";
        /// Opacity of solids as occluders; the paper takes that of the scene.
        ao_solid_opacity: f32 = 1.0, 0..=1, "";
        /// Whether samples of occlusion lie on the outer side of the surface alone; the paper has both sides.
        ao_hemisphere: Switch = Switch::ON, 0..=1, "";
        /// Factor of occlusion in shadows (AOShScale).
        ao_sh_scale: f32 = 1.0, 0..=1000, "";
        /// Exponent of shadows (AOShExp).
        ao_sh_exp: f32 = 1.5, 0.01..=64, "";
        /// What is added to shadows (AOShOffset).
        ao_sh_offset: f32 = -0.05, -1..=1, "";
        /// Red part of the colour of shadows (CShadowColor).
        shadow_red: f32 = 0.0, 0..=1, "";
        /// Green part of the colour of shadows.
        shadow_green: f32 = 0.0, 0..=1, "";
        /// Blue part of the colour of shadows.
        shadow_blue: f32 = 0.2, 0..=1, "";
        /// Whether irradiance is looked up in a map made once, as the paper suggests, in place of a sum for each pixel.
        irradiance_map: Switch = Switch::ON, 0..=1, "";
        /// Factor of irradiance (CIrrScale); the paper has no value.
        irr_scale: f32 = 1.0, 0..=1000000, "";
        /// Radius of the filter of shadows and irradiance, as a factor of the first search radius.
        filter: f32 = 1.5, 0..=16, "";
        /// Diameter of the lens, which blurs particles before and behind the distance of focus; 0 for a pinhole; not in the paper.
        aperture: f32 = 0.0, 0..=1000, "m";
        /// Depth at which particles are sharp; not in the paper.
        focus: f32 = 10.0, 0.0001..=1000000, "m";
        /// Seconds that the shutter is open, during which particles move by their velocities; 0 for still particles; not in the paper.
        shutter: f32 = 0.0, 0..=1000, "s";
        /// Places at which a moving particle is drawn; not in the paper.
        shutter_samples: u32 = 8, 1..=256, "";
    }
}
