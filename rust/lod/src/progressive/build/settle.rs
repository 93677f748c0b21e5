//! An edited mesh as a progressive mesh of its own.

use glam::Vec3;
use relievo_core::{Context, Progress, Result};

use super::hierarchy::{AT, BuildOptions, Progressive};
use crate::progressive::files::packing::{Lattice, Normal};
use crate::progressive::mesh::active::ActiveMesh;

impl ActiveMesh {
    /// The progressive mesh that has this one's edits at all levels, to be saved. Deviations of its levels are those it was
    /// built with.
    pub fn settled(&mut self, context: &Context) -> Progressive {
        // Coarser levels have followed; finer ones do on the way.
        self.at_finest(context, |mesh| {
            let mut made = mesh.settled_finest();
            made.wedges = mesh.settled_wedges(context);
            made
        })
    }

    fn settled_finest(&self) -> Progressive {
        let mut made = Progressive::clone(&self.whole);
        let Some(moves) = &self.moves else { return made };
        for leaf in 0..made.points.len() as u32 {
            if let Some(place) = moves.place(self.node(leaf)) {
                made.points[leaf as usize] = place.point.to_array();
                made.normals[leaf as usize] = Normal::new(place.normal);
            }
        }
        let splits: Vec<u32> = made.splits().map(|(split, ..)| split).collect();
        made.lattice = Lattice::around(splits.iter().map(|split| self.before_split(*split).point));
        for split in splits {
            let (number, place) = (split as usize, self.before_split(split));
            let leaf = (made.inner_points[number] & !AT) as usize;
            let stays = made.inner_points[number] & AT != 0 && Vec3::from(made.points[leaf]) == place.point;
            if !stays {
                made.inner_points[number] = made.lattice.pack(place.point);
            }
            made.inner_normals[number] = Normal::new(place.normal);
        }
        made
    }

    /// A progressive mesh that is built anew of the finest mesh with its edits: its levels deviate by what they tell,
    /// and have triangles where the surface needs them now. Its vertices are those of this one's finest mesh, in their
    /// order. Takes as long as building did, which [`Self::settled`] does not. Attributes weigh as
    /// [`crate::default_weight`] says.
    ///
    /// # Errors
    /// Fails as [`Progressive::build`].
    pub fn rebuilt(
        &mut self,
        context: &Context,
        options: &BuildOptions,
        progress: &mut dyn Progress,
    ) -> Result<Progressive> {
        let finest = self.at_finest(context, |mesh| mesh.extract());
        Progressive::build_extract(context, self.whole.attributes(), finest, options, progress)
    }
}
