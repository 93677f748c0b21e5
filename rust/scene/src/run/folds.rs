//! Says which surfaces their displacement folds.

use relievo_core::{Context, Result};

use crate::state::world::{Item, World};

/// Counts the folds of every object, and describes them by the index of each object that has some.
///
/// # Errors
/// Fails if memory for the points of a tile is refused.
pub(crate) fn count(context: &Context, world: &World) -> Result<Vec<(usize, String)>> {
    let mut found = Vec::new();
    for (index, item) in world.items().iter().enumerate() {
        let (folds, what) = match item {
            Item::Surface(surface) => (surface.displaced()?.folds(context)?, "tile"),
            Item::Triangles(item) => (item.object.displaced()?.folds(context), "face"),
            Item::Mesh(_) => continue,
        };
        if let Some(worst) = folds.worst {
            let turned = format!("its displacement turns {} of {} triangles over", folds.folded, folds.triangles);
            found.push((index, format!("{turned}, most of them on {what} {worst}")));
        }
    }
    Ok(found)
}
