//! What jobs make, and of which kind it is.

use relievo_core::{Error, Result};
use relievo_detail::Report;

use super::{
    RLV_JOB_KIND_BAKE_REPORT, RLV_JOB_KIND_BYTES, RLV_JOB_KIND_CASTER, RLV_JOB_KIND_CLIENT_STATUS,
    RLV_JOB_KIND_COLLIDER, RLV_JOB_KIND_CROWD_MODEL, RLV_JOB_KIND_DECAL, RLV_JOB_KIND_DOCUMENT,
    RLV_JOB_KIND_FLUID_REPORT, RLV_JOB_KIND_GRID, RLV_JOB_KIND_IMPRINT_REPORT, RLV_JOB_KIND_MESH, RLV_JOB_KIND_NONE,
    RLV_JOB_KIND_PARTICLES, RLV_JOB_KIND_PICTURE, RLV_JOB_KIND_PROCEDURAL, RLV_JOB_KIND_PROGRESSIVE,
    RLV_JOB_KIND_PTEX_REPORT, RLV_JOB_KIND_SURFACE, RLV_JOB_KIND_TISSUE, RLV_JOB_KIND_TRANSFER_REPORT,
};
use crate::border::registry;
use crate::details::bake::RlvBakeReport;
use crate::details::collider::RlvCollider;
use crate::details::decal::RlvDecal;
use crate::details::document::{RlvDocument, RlvTransferReport};
use crate::levels::progressive::RlvProgressive;
use crate::runtime::bytes::RlvBytes;
use crate::scenery::crowd::{RlvCrowdModel, RlvCrowdRefitReport};
use crate::scenery::picture::RlvPicture;
use crate::simulation::client::{ClientProduct, RlvClientStatus};
use crate::simulation::fluid::RlvFluidReport;
use crate::simulation::particles::RlvParticles;
use crate::simulation::tissue::{RlvTissue, RlvTissueReport};
use crate::surfaces::caster::RlvCaster;
use crate::surfaces::grid::RlvGrid;
use crate::surfaces::mesh::RlvMesh;
use crate::surfaces::procedural::RlvProcedural;
use crate::surfaces::ptex::RlvPtexReport;
use crate::surfaces::repair::RlvRepairReport;
use crate::surfaces::surface::RlvSurface;

/// What a job made.
pub enum Product {
    /// A reference to a mesh, which the job releases.
    Mesh(RlvMesh),
    /// The same, and how far the mesh deviates.
    Simplified(RlvMesh, f32),
    /// The same of a progressive mesh.
    Progressive(RlvProgressive),
    /// The same of a grid.
    Grid(RlvGrid),
    /// The same of a decal.
    Decal(RlvDecal),
    /// The same of a crowd model, and what changed if it was refitted.
    Crowd(RlvCrowdModel, Option<RlvCrowdRefitReport>),
    /// A mesh as above, and the report on its repair.
    Repaired(RlvMesh, Box<RlvRepairReport>),
    Imprint(Report),
    Bake(RlvBakeReport),
    /// A file without more to say about it.
    File,
    Ptex(RlvPtexReport),
    Transfer(RlvTransferReport),
    Fluid(RlvFluidReport),
    /// A model of soft tissue as above, and what it was built from, if it was not read.
    Tissue(RlvTissue, Option<RlvTissueReport>),
    /// Steps of soft tissue, without more to say about them.
    TissueSteps,
    /// The state of a scene that was submitted.
    Submitted(Box<RlvClientStatus>),
    /// The same of particles.
    Particles(RlvParticles),
    /// The same of a surface.
    Surface(RlvSurface),
    /// The same of a caster.
    Caster(RlvCaster),
    /// The same of primitives.
    Procedural(RlvProcedural),
    /// The same of a collider.
    Collider(RlvCollider),
    /// The same of a picture.
    Picture(RlvPicture),
    /// The same of a document.
    Document(RlvDocument),
    /// The same of bytes.
    Bytes(RlvBytes),
}

impl Product {
    /// Returns what it is: one of the `RLV_JOB_KIND_` values.
    fn kind(&self) -> u32 {
        match self {
            Self::Mesh(_) | Self::Simplified(..) | Self::Repaired(..) => RLV_JOB_KIND_MESH,
            Self::Progressive(_) => RLV_JOB_KIND_PROGRESSIVE,
            Self::Grid(_) => RLV_JOB_KIND_GRID,
            Self::Decal(_) => RLV_JOB_KIND_DECAL,
            Self::Crowd(..) => RLV_JOB_KIND_CROWD_MODEL,
            Self::Tissue(..) => RLV_JOB_KIND_TISSUE,
            Self::Particles(_) => RLV_JOB_KIND_PARTICLES,
            Self::Surface(_) => RLV_JOB_KIND_SURFACE,
            Self::Caster(_) => RLV_JOB_KIND_CASTER,
            Self::Procedural(_) => RLV_JOB_KIND_PROCEDURAL,
            Self::Collider(_) => RLV_JOB_KIND_COLLIDER,
            Self::Picture(_) => RLV_JOB_KIND_PICTURE,
            Self::Document(_) => RLV_JOB_KIND_DOCUMENT,
            Self::Bytes(_) => RLV_JOB_KIND_BYTES,
            Self::Imprint(_) => RLV_JOB_KIND_IMPRINT_REPORT,
            Self::Bake(_) => RLV_JOB_KIND_BAKE_REPORT,
            Self::Ptex(_) => RLV_JOB_KIND_PTEX_REPORT,
            Self::Transfer(_) => RLV_JOB_KIND_TRANSFER_REPORT,
            Self::Fluid(_) => RLV_JOB_KIND_FLUID_REPORT,
            Self::Submitted(_) => RLV_JOB_KIND_CLIENT_STATUS,
            Self::File | Self::TissueSteps => RLV_JOB_KIND_NONE,
        }
    }

    /// Returns it if it is of the kind that its job was started for.
    pub fn checked(self, kind: u32) -> Result<Self> {
        if self.kind() != kind {
            return Err(Error::internal(format!("the job makes {}, not {kind}", self.kind())));
        }
        Ok(self)
    }
}

impl From<ClientProduct> for Product {
    fn from(product: ClientProduct) -> Self {
        match product {
            ClientProduct::Status(status) => Self::Submitted(status),
            ClientProduct::Particles(particles) => Self::Particles(particles),
            ClientProduct::Mesh(mesh) => Self::Mesh(mesh),
        }
    }
}

impl Drop for Product {
    fn drop(&mut self) {
        // Nothing can be done about a host that released it too often.
        let _ = match self {
            Self::Mesh(mesh) | Self::Simplified(mesh, _) | Self::Repaired(mesh, _) => registry::release(*mesh),
            Self::Progressive(mesh) => registry::release(*mesh),
            Self::Grid(grid) => registry::release(*grid),
            Self::Decal(decal) => registry::release(*decal),
            Self::Tissue(tissue, _) => registry::release(*tissue),
            Self::Particles(particles) => registry::release(*particles),
            Self::Crowd(model, _) => registry::release(*model),
            Self::Surface(surface) => registry::release(*surface),
            Self::Caster(caster) => registry::release(*caster),
            Self::Procedural(procedural) => registry::release(*procedural),
            Self::Collider(collider) => registry::release(*collider),
            Self::Picture(picture) => registry::release(*picture),
            Self::Document(document) => registry::release(*document),
            Self::Bytes(bytes) => registry::release(*bytes),
            _ => Ok(()),
        };
    }
}
