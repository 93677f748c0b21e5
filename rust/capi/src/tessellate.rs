//! Triangles of surfaces and details; see `include/relievo/tessellate.h`.

use relievo_core::{Attribute, Context, Domain, Error, Mesh, Result, Values};
use relievo_surface::Surface;
use relievo_tiles::{Displaced, Displacement, DisplacementOptions, Tessellation};

use crate::array::{present, put};
use crate::descriptor::read_optional;
use crate::detail::RlvDetail;
use crate::mesh::{self, RlvMesh};
use crate::registry;
use crate::surface::RlvSurface;

descriptor! {
    pub struct RlvTessellateOptions {
        struct_size: u32,
        coarse: u32,
        fine: u32,
        places: u32,
    }
}

/// Cells along an edge of the cage.
#[derive(Clone, Copy)]
pub struct Cells {
    /// Beside tiles without displacement.
    coarse: u32,
    /// Beside tiles with displacement at most.
    fine: u32,
}

const MAX_CELLS: u32 = 512;

impl Cells {
    /// The cells, and whether places are wanted.
    ///
    /// # Safety
    /// `options` is NULL or a descriptor that starts with its size.
    pub unsafe fn new(options: *const RlvTessellateOptions) -> Result<(Self, bool)> {
        let default = RlvTessellateOptions { struct_size: 0, coarse: 0, fine: 0, places: 0 };
        // SAFETY: promised by the caller.
        let given = unsafe { read_optional(options, default) }?;
        for (name, value) in [("coarse", given.coarse), ("fine", given.fine)] {
            if value != 0 && !(value.is_power_of_two() && value <= MAX_CELLS) {
                return Err(Error::invalid(format!("a tile cannot have {value} cells a side"))
                    .at(name)
                    .advise(format!("use a power of two from 1 to {MAX_CELLS}, or 0 for the default")));
            }
        }
        let or = |value, default| if value == 0 { default } else { value };
        let coarse = or(given.coarse, 8);
        Ok((Self { coarse, fine: or(given.fine, 256).max(coarse) }, given.places != 0))
    }

    /// Cells a side of every tile: one per coefficient where there is displacement.
    fn rates(self, displaced: &Displaced<'_>) -> Vec<u32> {
        let field = displaced.field();
        let rate = |tile: u32| {
            let cells = field.density(tile).clamp(self.coarse, self.fine);
            if field.topology().is_sub(tile) { (cells / 2).max(1) } else { cells }
        };
        (0..field.tile_count() as u32).map(rate).collect()
    }
}

/// The triangles of a displaced surface, if they fit the memory limit.
pub fn tessellate(context: &Context, displaced: &Displaced<'_>, cage: &Mesh, cells: Cells) -> Result<Tessellation> {
    let rates = cells.rates(displaced);
    let quads: u64 = rates.iter().map(|rate| u64::from(*rate).pow(2)).sum();
    // A point with its normal, and for both triangles corners, indices of attributes, parameters and the tile.
    let bytes = quads.saturating_mul(24 + 2 * (12 + 12 + 24 + 4));
    if bytes > context.memory_limit() {
        return Err(Error::memory(format!("{} triangles do not fit the memory limit", 2 * quads))
            .advise("use fewer cells or raise the memory limit of the context"));
    }
    context.stats().time("tessellate", || displaced.tessellate(context, cage, &rates))
}

/// As [`tessellate`] for a surface without displacement.
pub fn tessellate_bare(context: &Context, surface: &Surface, cage: &Mesh, cells: Cells) -> Result<Tessellation> {
    let nothing = Displacement::new(surface.topology().clone(), &DisplacementOptions::default())?;
    tessellate(context, &Displaced::new(surface, nothing.field())?, cage, cells)
}

/// The mesh, with the tile of every face and the parameters of every corner as attributes if they are wanted.
fn with_places(made: Tessellation, wanted: bool) -> Mesh {
    let Tessellation { mut mesh, tiles, parameters } = made;
    if wanted {
        let attribute =
            |name: &str, domain, width, values| Attribute { name: name.into(), domain, width, values, indices: None };
        mesh.attributes.retain(|attribute| attribute.name != "tile" && attribute.name != "tile_uv");
        mesh.attributes.push(attribute("tile", Domain::Face, 1, Values::U32(tiles)));
        let parameters = Values::F32(parameters.into_flattened());
        mesh.attributes.push(attribute("tile_uv", Domain::Corner, 2, parameters));
    }
    mesh
}

entry! {
    fn rlv_tessellate_surface(surface: RlvSurface, options: *const RlvTessellateOptions, out: *mut RlvMesh) {
        present("out", out)?;
        let object = registry::get(surface)?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        let (cells, places) = unsafe { Cells::new(options) }?;
        let pose = object.snapshot();
        let made = tessellate_bare(&object.context.context, &pose.surface, &object.cage, cells)?;
        let handle = mesh::register(object.context.clone(), with_places(made, places))?;
        // SAFETY: checked above.
        unsafe { put(out, handle) };
        Ok(())
    }

    fn rlv_tessellate_detail(detail: RlvDetail, options: *const RlvTessellateOptions, out: *mut RlvMesh) {
        present("out", out)?;
        let object = registry::get(detail)?;
        // SAFETY: the caller gives NULL or a descriptor that starts with its size.
        let (cells, places) = unsafe { Cells::new(options) }?;
        let view = object.view();
        let made = tessellate(&object.context.context, &view.displaced()?, &view.cage, cells)?;
        let handle = mesh::register(object.context.clone(), with_places(made, places))?;
        // SAFETY: checked above.
        unsafe { put(out, handle) };
        Ok(())
    }
}
