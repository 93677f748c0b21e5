//! The view, the environment and the settings of foam as kernels read them.

use crate::foam::environment::LightMap;
use crate::foam::projection::{FoamView, Projection};
use crate::foam::settings::FoamSettings;
use relievo_gpu::wgsl::foam::FoamLook;

/// Makes the look of a view before its environment is known.
pub fn look(settings: &FoamSettings, view: &FoamView) -> FoamLook {
    let projection = Projection::new(view);
    let [right, up, back] = [projection.axes.x_axis, projection.axes.y_axis, projection.axes.z_axis].map(Into::into);
    FoamLook {
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
        ..FoamLook::default()
    }
}

/// Sets the axes and the rows of a map of light.
pub fn light(look: &mut FoamLook, map: &LightMap) {
    let [zenith, first, second] = map.axes.map(Into::into);
    (look.zenith, look.first, look.second, look.rows) = (zenith, first, second, map.rows);
}
