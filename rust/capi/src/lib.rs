//! The C ABI of Relievo: the only crate whose functions C and C++ call.
//!
//! One noun is one header in `include/relievo`, one file here and one test in `tests/c`. The headers are the
//! documentation of every function; `tests/parity.rs` holds them and this crate to the same signatures, values and
//! layouts. Every function goes through [`entry!`](border), which keeps panics inside and remembers the last error;
//! every handle goes through the [`registry`], every array through [`array`] and every descriptor through
//! [`descriptor`].

// The headers document every item; repeating them here would let the two drift apart.
#![allow(missing_docs, clippy::missing_safety_doc)]

#[macro_use]
pub mod border;
pub mod array;
#[macro_use]
pub mod descriptor;
pub mod adapter;
pub mod arrival;
pub mod bake;
pub mod bezier;
pub mod brush;
pub mod buffer;
pub mod caster;
pub mod channel;
pub mod collider;
pub mod color_buffer;
pub mod context;
pub mod detail;
pub mod device_level;
pub mod document;
pub mod error;
pub mod evaluate;
pub mod fluid;
pub mod imprint;
pub mod isosurface;
pub mod job;
pub mod layer;
pub mod level;
pub mod mesh;
pub mod parameter;
pub mod particles;
pub mod picture;
pub mod procedural;
pub mod progressive;
pub mod ptex;
pub mod registry;
pub mod shape;
pub mod simplify;
pub mod stroke;
pub mod surface;
pub mod tessellate;
pub mod version;
pub mod view;

/// The C layout of every descriptor and the value of every constant, for the test that compares them with the headers.
pub fn layouts() -> Vec<descriptor::Layout> {
    vec![
        error::RlvError::layout(),
        adapter::RlvAdapterInfo::layout(),
        arrival::RlvArrivalInfo::layout(),
        context::RlvContextOptions::layout(),
        context::RlvContextInfo::layout(),
        context::RlvContextStat::layout(),
        mesh::RlvMeshArrays::layout(),
        mesh::RlvMeshInfo::layout(),
        mesh::RlvAttributeArrays::layout(),
        mesh::RlvAttributeInfo::layout(),
        surface::RlvSurfaceOptions::layout(),
        surface::RlvSurfaceInfo::layout(),
        surface::RlvTileInfo::layout(),
        evaluate::RlvEvaluateArrays::layout(),
        detail::RlvDetailOptions::layout(),
        detail::RlvPaintOptions::layout(),
        detail::RlvVectorOptions::layout(),
        detail::RlvDecayOptions::layout(),
        detail::RlvChannelInfo::layout(),
        device_level::RlvDeviceLevelInfo::layout(),
        device_level::RlvDeviceLevelVulkan::layout(),
        fluid::RlvFluidOptions::layout(),
        fluid::RlvFluidInfo::layout(),
        fluid::RlvFluidParticles::layout(),
        fluid::RlvFluidArrays::layout(),
        fluid::RlvFluidForce::layout(),
        fluid::RlvFluidEmitterOptions::layout(),
        fluid::RlvFluidColliderOptions::layout(),
        fluid::RlvFluidReport::layout(),
        isosurface::RlvIsosurfaceOptions::layout(),
        isosurface::RlvIsosurfaceParticles::layout(),
        isosurface::RlvIsosurfaceInfo::layout(),
        isosurface::RlvIsosurfaceMeshOptions::layout(),
        isosurface::RlvIsosurfaceClasses::layout(),
        isosurface::RlvIsosurfaceRay::layout(),
        isosurface::RlvIsosurfaceHit::layout(),
        isosurface::RlvIsosurfaceTable::layout(),
        job::RlvJobInfo::layout(),
        layer::RlvLayerOptions::layout(),
        layer::RlvLayerInfo::layout(),
        level::RlvLevelInfo::layout(),
        level::RlvLevelView::layout(),
        level::RlvLevelRegion::layout(),
        level::RlvLevelSculpted::layout(),
        level::RlvLevelHandle::layout(),
        level::RlvLevelEdit::layout(),
        level::RlvLevelBuffers::layout(),
        level::RlvLevelUpdate::layout(),
        level::RlvLevelMisplaced::layout(),
        level::RlvLevelKey::layout(),
        level::RlvLevelTrack::layout(),
        level::RlvLevelMotion::layout(),
        document::RlvDocumentInfo::layout(),
        document::RlvDocumentChanges::layout(),
        document::RlvTransferOptions::layout(),
        document::RlvTransferReport::layout(),
        bezier::RlvBezierArrays::layout(),
        bezier::RlvBezierInfo::layout(),
        bezier::RlvBezierView::layout(),
        bezier::RlvBezierLevels::layout(),
        bezier::RlvBezierTriangles::layout(),
        bake::RlvBakeOptions::layout(),
        bake::RlvBakePicture::layout(),
        bake::RlvBakeReport::layout(),
        particles::RlvParticlesArrays::layout(),
        particles::RlvParticlesInfo::layout(),
        picture::RlvPictureInfo::layout(),
        picture::RlvPictureImage::layout(),
        picture::RlvPictureMeta::layout(),
        procedural::RlvProceduralOptions::layout(),
        procedural::RlvProceduralInfo::layout(),
        procedural::RlvProceduralTable::layout(),
        procedural::RlvProceduralHits::layout(),
        progressive::RlvProgressiveOptions::layout(),
        progressive::RlvProgressiveInfo::layout(),
        ptex::RlvPtexOptions::layout(),
        ptex::RlvPtexReport::layout(),
        simplify::RlvSimplifyWeight::layout(),
        simplify::RlvSimplifyOptions::layout(),
        detail::RlvDetailInfo::layout(),
        detail::RlvDetailChanges::layout(),
        detail::RlvDetailTileInfo::layout(),
        tessellate::RlvTessellateOptions::layout(),
        tessellate::RlvTessellationInfo::layout(),
        tessellate::RlvTessellationChanges::layout(),
        collider::RlvColliderInfo::layout(),
        collider::RlvToolSettings::layout(),
        parameter::RlvParameter::layout(),
        imprint::RlvImprintSettings::layout(),
        imprint::RlvImprintMoment::layout(),
        imprint::RlvImprintReport::layout(),
        buffer::RlvBufferInfo::layout(),
        buffer::RlvBufferVulkan::layout(),
        color_buffer::RlvColorBufferInfo::layout(),
        color_buffer::RlvColorBufferVulkan::layout(),
        brush::RlvBrushOptions::layout(),
        brush::RlvBrushSettings::layout(),
        brush::RlvStampOptions::layout(),
        brush::RlvStampSettings::layout(),
        stroke::RlvStrokePoint::layout(),
        stroke::RlvStrokeReport::layout(),
        caster::RlvHit::layout(),
        caster::RlvRayArrays::layout(),
    ]
}

/// The constants of every noun, name and value.
pub fn constants() -> Vec<(&'static str, i64)> {
    [
        version::CONSTANTS,
        adapter::CONSTANTS,
        error::CONSTANTS,
        context::CONSTANTS,
        mesh::CONSTANTS,
        surface::CONSTANTS,
        detail::CONSTANTS,
        bake::CONSTANTS,
        brush::CONSTANTS,
        caster::CONSTANTS,
        fluid::CONSTANTS,
        isosurface::CONSTANTS,
        job::CONSTANTS,
        layer::CONSTANTS,
        parameter::CONSTANTS,
        picture::CONSTANTS,
        ptex::CONSTANTS,
    ]
    .concat()
}
