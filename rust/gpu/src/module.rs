//! WGSL modules and their imports.
//!
//! A module is a file of `shaders/`. A line `// import NAME` takes in the module NAME, once, with what that imports,
//! before the module itself; an import line therefore stands before everything else of its file. Lines of the composed
//! text are mapped back, so that messages name the file that a reader would open.

use std::collections::BTreeSet;

use relievo_core::{Error, Result};

/// All modules by name, in the order of the alphabet.
pub const MODULES: &[(&str, &str)] = &[
    ("bezier", include_str!("../../../shaders/bezier.wgsl")),
    ("bezier_draw", include_str!("../../../shaders/bezier_draw.wgsl")),
    ("bezier_samples", include_str!("../../../shaders/bezier_samples.wgsl")),
    ("block_sums", include_str!("../../../shaders/block_sums.wgsl")),
    ("brush", include_str!("../../../shaders/brush.wgsl")),
    ("brush_bend", include_str!("../../../shaders/brush_bend.wgsl")),
    ("brush_bend_modes", include_str!("../../../shaders/brush_bend_modes.wgsl")),
    ("brush_bounds", include_str!("../../../shaders/brush_bounds.wgsl")),
    ("brush_edit", include_str!("../../../shaders/brush_edit.wgsl")),
    ("brush_intersect", include_str!("../../../shaders/brush_intersect.wgsl")),
    ("brush_manage", include_str!("../../../shaders/brush_manage.wgsl")),
    ("brush_paint", include_str!("../../../shaders/brush_paint.wgsl")),
    ("brush_paint_modes", include_str!("../../../shaders/brush_paint_modes.wgsl")),
    ("brush_sculpt", include_str!("../../../shaders/brush_sculpt.wgsl")),
    ("brush_sculpt_modes", include_str!("../../../shaders/brush_sculpt_modes.wgsl")),
    ("brush_smear", include_str!("../../../shaders/brush_smear.wgsl")),
    ("brush_spread", include_str!("../../../shaders/brush_spread.wgsl")),
    ("brush_stamp", include_str!("../../../shaders/brush_stamp.wgsl")),
    ("brush_still", include_str!("../../../shaders/brush_still.wgsl")),
    ("brush_tiles", include_str!("../../../shaders/brush_tiles.wgsl")),
    ("colors", include_str!("../../../shaders/colors.wgsl")),
    ("common", include_str!("../../../shaders/common.wgsl")),
    ("compaction", include_str!("../../../shaders/compaction.wgsl")),
    ("fade", include_str!("../../../shaders/fade.wgsl")),
    ("falloff", include_str!("../../../shaders/falloff.wgsl")),
    ("fluid", include_str!("../../../shaders/fluid.wgsl")),
    ("fluid_arrive", include_str!("../../../shaders/fluid_arrive.wgsl")),
    ("fluid_begin", include_str!("../../../shaders/fluid_begin.wgsl")),
    ("fluid_cells", include_str!("../../../shaders/fluid_cells.wgsl")),
    ("fluid_forces", include_str!("../../../shaders/fluid_forces.wgsl")),
    ("fluid_given", include_str!("../../../shaders/fluid_given.wgsl")),
    ("fluid_hold", include_str!("../../../shaders/fluid_hold.wgsl")),
    ("fluid_near", include_str!("../../../shaders/fluid_near.wgsl")),
    ("fluid_noise", include_str!("../../../shaders/fluid_noise.wgsl")),
    ("fluid_press", include_str!("../../../shaders/fluid_press.wgsl")),
    ("fluid_sums", include_str!("../../../shaders/fluid_sums.wgsl")),
    ("fluid_surface", include_str!("../../../shaders/fluid_surface.wgsl")),
    ("fluid_surface_around", include_str!("../../../shaders/fluid_surface_around.wgsl")),
    ("fluid_surface_blind", include_str!("../../../shaders/fluid_surface_blind.wgsl")),
    ("fluid_surface_bricks", include_str!("../../../shaders/fluid_surface_bricks.wgsl")),
    ("fluid_surface_cells", include_str!("../../../shaders/fluid_surface_cells.wgsl")),
    ("fluid_surface_cross", include_str!("../../../shaders/fluid_surface_cross.wgsl")),
    ("fluid_surface_sort", include_str!("../../../shaders/fluid_surface_sort.wgsl")),
    ("fluid_surface_values", include_str!("../../../shaders/fluid_surface_values.wgsl")),
    ("grid", include_str!("../../../shaders/grid.wgsl")),
    ("group_sums", include_str!("../../../shaders/group_sums.wgsl")),
    ("halves", include_str!("../../../shaders/halves.wgsl")),
    ("imprint_arrange", include_str!("../../../shaders/imprint_arrange.wgsl")),
    ("imprint_box", include_str!("../../../shaders/imprint_box.wgsl")),
    ("imprint_cast", include_str!("../../../shaders/imprint_cast.wgsl")),
    ("imprint_count", include_str!("../../../shaders/imprint_count.wgsl")),
    ("imprint_cross", include_str!("../../../shaders/imprint_cross.wgsl")),
    ("imprint_cull", include_str!("../../../shaders/imprint_cull.wgsl")),
    ("imprint_facet", include_str!("../../../shaders/imprint_facet.wgsl")),
    ("imprint_hull", include_str!("../../../shaders/imprint_hull.wgsl")),
    ("imprint_keep", include_str!("../../../shaders/imprint_keep.wgsl")),
    ("imprint_link", include_str!("../../../shaders/imprint_link.wgsl")),
    ("imprint_meet", include_str!("../../../shaders/imprint_meet.wgsl")),
    ("imprint_patches", include_str!("../../../shaders/imprint_patches.wgsl")),
    ("imprint_place", include_str!("../../../shaders/imprint_place.wgsl")),
    ("imprint_range", include_str!("../../../shaders/imprint_range.wgsl")),
    ("imprint_ray", include_str!("../../../shaders/imprint_ray.wgsl")),
    ("imprint_record", include_str!("../../../shaders/imprint_record.wgsl")),
    ("imprint_resolve", include_str!("../../../shaders/imprint_resolve.wgsl")),
    ("imprint_rim", include_str!("../../../shaders/imprint_rim.wgsl")),
    ("imprint_rim_cells", include_str!("../../../shaders/imprint_rim_cells.wgsl")),
    ("imprint_rim_gather", include_str!("../../../shaders/imprint_rim_gather.wgsl")),
    ("imprint_rim_join", include_str!("../../../shaders/imprint_rim_join.wgsl")),
    ("imprint_rim_list", include_str!("../../../shaders/imprint_rim_list.wgsl")),
    ("imprint_rim_profile", include_str!("../../../shaders/imprint_rim_profile.wgsl")),
    ("imprint_rim_push", include_str!("../../../shaders/imprint_rim_push.wgsl")),
    ("imprint_rim_raise", include_str!("../../../shaders/imprint_rim_raise.wgsl")),
    ("imprint_smooth", include_str!("../../../shaders/imprint_smooth.wgsl")),
    ("imprint_snap", include_str!("../../../shaders/imprint_snap.wgsl")),
    ("imprint_solid", include_str!("../../../shaders/imprint_solid.wgsl")),
    ("imprint_step", include_str!("../../../shaders/imprint_step.wgsl")),
    ("imprint_tile", include_str!("../../../shaders/imprint_tile.wgsl")),
    ("imprint_touch", include_str!("../../../shaders/imprint_touch.wgsl")),
    ("imprint_under", include_str!("../../../shaders/imprint_under.wgsl")),
    ("imprint_vectors", include_str!("../../../shaders/imprint_vectors.wgsl")),
    ("imprint_write", include_str!("../../../shaders/imprint_write.wgsl")),
    ("indirect_draw", include_str!("../../../shaders/indirect_draw.wgsl")),
    ("mesh_draw", include_str!("../../../shaders/mesh_draw.wgsl")),
    ("octahedron", include_str!("../../../shaders/octahedron.wgsl")),
    ("progressive", include_str!("../../../shaders/progressive.wgsl")),
    ("progressive_bits", include_str!("../../../shaders/progressive_bits.wgsl")),
    ("progressive_coarsen", include_str!("../../../shaders/progressive_coarsen.wgsl")),
    ("progressive_directions", include_str!("../../../shaders/progressive_directions.wgsl")),
    ("progressive_edit", include_str!("../../../shaders/progressive_edit.wgsl")),
    ("progressive_edited", include_str!("../../../shaders/progressive_edited.wgsl")),
    ("progressive_fit", include_str!("../../../shaders/progressive_fit.wgsl")),
    ("progressive_follow", include_str!("../../../shaders/progressive_follow.wgsl")),
    ("progressive_mark", include_str!("../../../shaders/progressive_mark.wgsl")),
    ("progressive_notes", include_str!("../../../shaders/progressive_notes.wgsl")),
    ("progressive_places", include_str!("../../../shaders/progressive_places.wgsl")),
    ("progressive_record", include_str!("../../../shaders/progressive_record.wgsl")),
    ("progressive_refine", include_str!("../../../shaders/progressive_refine.wgsl")),
    ("progressive_ring", include_str!("../../../shaders/progressive_ring.wgsl")),
    ("progressive_spread", include_str!("../../../shaders/progressive_spread.wgsl")),
    ("progressive_stars", include_str!("../../../shaders/progressive_stars.wgsl")),
    ("progressive_touch", include_str!("../../../shaders/progressive_touch.wgsl")),
    ("progressive_view", include_str!("../../../shaders/progressive_view.wgsl")),
    ("progressive_wedges", include_str!("../../../shaders/progressive_wedges.wgsl")),
    ("progressive_write", include_str!("../../../shaders/progressive_write.wgsl")),
    ("ring", include_str!("../../../shaders/ring.wgsl")),
    ("ring_curves", include_str!("../../../shaders/ring_curves.wgsl")),
    ("ring_links", include_str!("../../../shaders/ring_links.wgsl")),
    ("ring_means", include_str!("../../../shaders/ring_means.wgsl")),
    ("ring_texels", include_str!("../../../shaders/ring_texels.wgsl")),
    ("ring_tiles", include_str!("../../../shaders/ring_tiles.wgsl")),
    ("ring_turns", include_str!("../../../shaders/ring_turns.wgsl")),
    ("ring_vertices", include_str!("../../../shaders/ring_vertices.wgsl")),
    ("scan", include_str!("../../../shaders/scan.wgsl")),
    ("shade", include_str!("../../../shaders/shade.wgsl")),
    ("sort", include_str!("../../../shaders/sort.wgsl")),
    ("surface", include_str!("../../../shaders/surface.wgsl")),
    ("surface_evaluate", include_str!("../../../shaders/surface_evaluate.wgsl")),
    ("surface_pose", include_str!("../../../shaders/surface_pose.wgsl")),
    ("tiles", include_str!("../../../shaders/tiles.wgsl")),
    ("tiles_draw", include_str!("../../../shaders/tiles_draw.wgsl")),
    ("tiles_evaluate", include_str!("../../../shaders/tiles_evaluate.wgsl")),
    ("tints", include_str!("../../../shaders/tints.wgsl")),
    ("triangle_brush", include_str!("../../../shaders/triangle_brush.wgsl")),
    ("triangle_imprint", include_str!("../../../shaders/triangle_imprint.wgsl")),
    ("triangle_imprint_cull", include_str!("../../../shaders/triangle_imprint_cull.wgsl")),
    ("triangle_imprint_fan", include_str!("../../../shaders/triangle_imprint_fan.wgsl")),
    ("triangle_imprint_foot", include_str!("../../../shaders/triangle_imprint_foot.wgsl")),
    ("triangle_imprint_note", include_str!("../../../shaders/triangle_imprint_note.wgsl")),
    ("triangle_imprint_rim_cells", include_str!("../../../shaders/triangle_imprint_rim_cells.wgsl")),
    ("triangle_imprint_rim_gather", include_str!("../../../shaders/triangle_imprint_rim_gather.wgsl")),
    ("triangle_imprint_rim_note", include_str!("../../../shaders/triangle_imprint_rim_note.wgsl")),
    ("triangle_imprint_rim_pieces", include_str!("../../../shaders/triangle_imprint_rim_pieces.wgsl")),
    ("triangle_imprint_slot", include_str!("../../../shaders/triangle_imprint_slot.wgsl")),
    ("triangle_imprint_smooth", include_str!("../../../shaders/triangle_imprint_smooth.wgsl")),
    ("triangle_imprint_touch", include_str!("../../../shaders/triangle_imprint_touch.wgsl")),
    ("triangle_intersect", include_str!("../../../shaders/triangle_intersect.wgsl")),
    ("triangles", include_str!("../../../shaders/triangles.wgsl")),
    ("triangles_draw", include_str!("../../../shaders/triangles_draw.wgsl")),
    ("vectors", include_str!("../../../shaders/vectors.wgsl")),
    ("wide", include_str!("../../../shaders/wide.wgsl")),
];

/// What begins a line that imports.
const IMPORT: &str = "// import ";

/// A module with all that it imports.
#[derive(Clone, Debug, Default)]
pub struct Composed {
    /// The WGSL text.
    pub text: String,
    /// For every line of the text the module it is from and its line there, from 1.
    lines: Vec<(&'static str, u32)>,
}

impl Composed {
    /// The file and line that line `line` (from 1) of the text is from.
    pub fn place(&self, line: u32) -> String {
        match self.lines.get((line as usize).saturating_sub(1)) {
            Some((module, line)) => format!("shaders/{module}.wgsl:{line}"),
            None => format!("composed line {line}"),
        }
    }
}

fn source(name: &str) -> Result<(&'static str, &'static str)> {
    MODULES
        .iter()
        .find(|(module, _)| *module == name)
        .copied()
        .ok_or_else(|| Error::internal(format!("there is no WGSL module `{name}`")))
}

/// The module `name` with all that it imports. Fails where a module does not exist.
pub fn compose(name: &str) -> Result<Composed> {
    let mut composed = Composed::default();
    append(name, &mut BTreeSet::new(), &mut composed)?;
    Ok(composed)
}

fn append(name: &str, seen: &mut BTreeSet<&'static str>, composed: &mut Composed) -> Result<()> {
    let (name, text) = source(name)?;
    if !seen.insert(name) {
        return Ok(());
    }
    for imported in text.lines().filter_map(|line| line.strip_prefix(IMPORT)) {
        append(imported.trim(), seen, composed).map_err(|error| error.at(format!("shaders/{name}.wgsl")))?;
    }
    for (line, text) in (1..).zip(text.lines()) {
        composed.text.push_str(text);
        composed.text.push('\n');
        composed.lines.push((name, line));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use wgpu::naga;

    #[test]
    fn the_list_is_the_folder() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../shaders");
        let mut files: Vec<_> = std::fs::read_dir(folder)
            .expect("the folder")
            .map(|entry| entry.expect("an entry").file_name().into_string().expect("a name"))
            .collect();
        files.sort();
        let listed: Vec<_> = MODULES.iter().map(|(name, _)| format!("{name}.wgsl")).collect();
        assert_eq!(files, listed);
    }

    #[test]
    fn every_module_is_valid() {
        use naga::valid::{Capabilities, ValidationFlags, Validator};
        for (name, _) in MODULES {
            let composed = compose(name).expect("its imports");
            let place = |line: Option<u32>| line.map_or((*name).to_owned(), |line| composed.place(line));
            let module = naga::front::wgsl::parse_str(&composed.text).unwrap_or_else(|error| {
                let line = error.location(&composed.text).map(|at| at.line_number);
                panic!("{}: {}", place(line), error.emit_to_string(&composed.text))
            });
            let capabilities = Capabilities::IMMEDIATES | Capabilities::SHADER_FLOAT16_IN_FLOAT32;
            let checked = Validator::new(ValidationFlags::all(), capabilities).validate(&module);
            if let Err(error) = checked {
                let line = error.location(&composed.text).map(|at| at.line_number);
                panic!("{}: {}", place(line), error.emit_to_string(&composed.text));
            }
        }
    }

    #[test]
    fn imports_come_once_and_lines_are_mapped_back() {
        let composed = compose("sort").expect("its imports");
        let common = source("common").expect("the module").1;
        assert_eq!(composed.text.matches("fn linear_group").count(), 1);
        assert_eq!(composed.place(1), "shaders/common.wgsl:1");
        let after = common.lines().count() as u32;
        assert_eq!(composed.place(after), format!("shaders/common.wgsl:{after}"));
        assert_eq!(composed.place(after + 3), "shaders/sort.wgsl:3");
        assert_eq!(composed.text.lines().count(), composed.lines.len());
    }
}
