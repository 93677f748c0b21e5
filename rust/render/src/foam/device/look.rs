//! The view, the environment and the settings of foam as kernels read them.

use bytemuck::{Pod, Zeroable};

use crate::foam::environment::LightMap;
use crate::foam::projection::{FoamView, Projection};
use crate::foam::settings::FoamSettings;

/// As in `foam.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct FoamLook {
    pub right: [f32; 3],
    pub width: u32,
    pub up: [f32; 3],
    pub height: u32,
    pub back: [f32; 3],
    pub is_parallel: u32,
    pub zenith: [f32; 3],
    pub scale: f32,
    pub first: [f32; 3],
    pub rows: u32,
    pub second: [f32; 3],
    pub irr_scale: f32,
    pub shadow_color: [f32; 3],
    pub radius: f32,
    pub near_depth: f32,
    pub aperture: f32,
    pub focus: f32,
    pub eta_max: f32,
    pub lifetime_n: f32,
    pub lifetime_m: f32,
    pub rho_mod: f32,
    pub rho_exp: f32,
    pub ao_init_sr_fac: f32,
    pub ao_sr_inc_fac: f32,
    pub ao_passes: u32,
    pub ao_s_dens: f32,
    pub ao_min_samp: u32,
    pub ao_max_samp: u32,
    pub ao_max_occl_dist: f32,
    pub ao_fluid_opacity: f32,
    pub ao_solid_opacity: f32,
    pub ao_hemisphere: u32,
    pub ao_sh_scale: f32,
    pub ao_sh_exp: f32,
    pub ao_sh_offset: f32,
    pub irradiance_map: u32,
    pub filter_radius: f32,
    padding: u32,
}

impl FoamLook {
    /// Makes that of a view before its environment is known.
    pub fn new(settings: &FoamSettings, view: &FoamView) -> Self {
        let projection = Projection::new(view);
        let [right, up, back] =
            [projection.axes.x_axis, projection.axes.y_axis, projection.axes.z_axis].map(Into::into);
        Self {
            right,
            up,
            back,
            width: view.width,
            height: view.height,
            is_parallel: projection.is_parallel.into(),
            scale: projection.scale,
            irr_scale: settings.irr_scale,
            shadow_color: [settings.shadow_red, settings.shadow_green, settings.shadow_blue],
            radius: settings.radius,
            near_depth: settings.near_depth,
            aperture: settings.aperture,
            focus: settings.focus,
            eta_max: settings.eta_max,
            lifetime_n: settings.lifetime_n,
            lifetime_m: settings.lifetime_m,
            rho_mod: settings.rho_mod,
            rho_exp: settings.rho_exp,
            ao_init_sr_fac: settings.ao_init_sr_fac,
            ao_sr_inc_fac: settings.ao_sr_inc_fac,
            ao_passes: settings.ao_passes,
            ao_s_dens: settings.ao_s_dens,
            ao_min_samp: settings.ao_min_samp,
            ao_max_samp: settings.ao_max_samp,
            ao_max_occl_dist: settings.ao_max_occl_dist,
            ao_fluid_opacity: settings.ao_fluid_opacity,
            ao_solid_opacity: settings.ao_solid_opacity,
            ao_hemisphere: settings.ao_hemisphere.is_on().into(),
            ao_sh_scale: settings.ao_sh_scale,
            ao_sh_exp: settings.ao_sh_exp,
            ao_sh_offset: settings.ao_sh_offset,
            irradiance_map: settings.irradiance_map.is_on().into(),
            filter_radius: settings.filter * settings.ao_init_sr_fac,
            ..Self::default()
        }
    }

    /// Sets the axes and the rows of a map of light.
    pub fn light(&mut self, map: &LightMap) {
        let [zenith, first, second] = map.axes.map(Into::into);
        (self.zenith, self.first, self.second, self.rows) = (zenith, first, second, map.rows);
    }
}
