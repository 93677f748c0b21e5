//! What the loaded library can do on this machine; see `include/relievo/capability.h`.

use relievo_core::Context;

use crate::border::array::{Output, Plain, fixed, present, put};
use crate::border::descriptor::write_descriptor;
use crate::runtime::context::{MAX_THREADS, RLV_NAME_SIZE};
use crate::runtime::version::version_of;

constants! {
    u32:
    RLV_CONTENT_MESH = 0,
    RLV_CONTENT_PATCHES = 1,
    RLV_CONTENT_PARTICLES = 2,
    RLV_CONTENT_GRID = 3,
    RLV_CONTENT_TEXTURE = 4,
    RLV_CONTENT_DOCUMENT = 5,
    RLV_CONTENT_PROGRESSIVE = 6,
    RLV_CONTENT_CROWD = 7,
    RLV_CONTENT_TISSUE = 8,
}

descriptor! {
    pub struct RlvCapability {
        struct_size: u32,
        version: u32,
        embree_version: u32,
        opensubdiv_version: u32,
        openvdb_version: u32,
        has_devices: u32,
        has_usd: u32,
        has_shaders: u32,
        has_tls: u32,
        adapter_count: u32,
        cores: u32,
        max_threads: u32,
        max_isolation: u32,
        reserved: u32,
        max_objects: u64,
        simd: [u8; RLV_NAME_SIZE as usize],
    }
}

descriptor! {
    pub struct RlvCapabilityFormat {
        content: u32,
        can_read: u32,
        can_write: u32,
        can_write_bytes: u32,
        extension: [u8; RLV_NAME_SIZE as usize],
    }
}

impl Default for RlvCapabilityFormat {
    fn default() -> Self {
        Self { content: 0, can_read: 0, can_write: 0, can_write_bytes: 0, extension: fixed("") }
    }
}

// SAFETY: integers, then bytes up to a multiple of four: no padding, no invalid patterns.
unsafe impl Plain for RlvCapabilityFormat {}

/// Levels to which features can be isolated.
const MAX_ISOLATION: u32 = 10;

/// Content, extension, and whether such files can be read, written, and made as bytes.
type Format = (u32, &'static str, [bool; 3]);

/// The formats of this build on this machine, by content.
fn formats() -> Vec<Format> {
    const READ: [bool; 3] = [true, false, false];
    const FILE: [bool; 3] = [true, true, false];
    const ALL: [bool; 3] = [true, true, true];
    let mut formats: Vec<Format> =
        vec![(RLV_CONTENT_MESH, "obj", ALL), (RLV_CONTENT_MESH, "ply", ALL), (RLV_CONTENT_MESH, "glb", ALL)];
    formats.extend(["stl", "off"].map(|extension| (RLV_CONTENT_MESH, extension, FILE)));
    formats.push((RLV_CONTENT_MESH, "gltf", READ));
    if cfg!(feature = "openusd") {
        formats.extend(["usd", "usda"].map(|extension| (RLV_CONTENT_MESH, extension, FILE)));
        formats.extend(["usdc", "usdz"].map(|extension| (RLV_CONTENT_MESH, extension, READ)));
    }
    formats.push((RLV_CONTENT_PATCHES, "bpt", READ));
    formats.extend(["rlvfluid", "bgeo", "vtk", "ply"].map(|extension| (RLV_CONTENT_PARTICLES, extension, FILE)));
    if relievo_openvdb::Module::open().is_ok() {
        formats.extend([RLV_CONTENT_PARTICLES, RLV_CONTENT_GRID].map(|content| (content, "vdb", FILE)));
    }
    formats.extend([
        (RLV_CONTENT_TEXTURE, "ptx", FILE),
        (RLV_CONTENT_DOCUMENT, "relievo", ALL),
        (RLV_CONTENT_PROGRESSIVE, "rlvpm", ALL),
        (RLV_CONTENT_CROWD, "rcrowd", ALL),
        (RLV_CONTENT_TISSUE, "rtissue", ALL),
        (RLV_CONTENT_TISSUE, "inp", FILE),
    ]);
    formats
}

entry! {
    fn rlv_capability_get(out: *mut RlvCapability) {
        let number = |version: [u32; 3]| version_of(version[0], version[1], version[2]);
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let capability = RlvCapability {
            struct_size: 0,
            version: crate::runtime::version::rlv_version(),
            embree_version: relievo_embree::version().map_or(0, number),
            opensubdiv_version: number(relievo_surface::opensubdiv_version()),
            openvdb_version: relievo_openvdb::Module::open().map_or(0, |module| number(module.library_version())),
            has_devices: u32::from(cfg!(feature = "wgpu")),
            has_usd: u32::from(cfg!(feature = "openusd")),
            has_shaders: u32::from(cfg!(feature = "shader")),
            has_tls: u32::from(cfg!(feature = "tls")),
            adapter_count: u32::try_from(relievo_gpu::adapters().len()).unwrap_or(u32::MAX),
            cores: u32::try_from(cores).unwrap_or(u32::MAX),
            max_threads: MAX_THREADS,
            max_isolation: MAX_ISOLATION,
            reserved: 0,
            max_objects: 1 << 32,
            simd: fixed(Context::serial().level().name()),
        };
        // SAFETY: the caller gives a descriptor that starts with its size, or NULL.
        unsafe { write_descriptor(out, capability) }
    }

    fn rlv_capability_list(formats: *mut RlvCapabilityFormat, capacity: usize, count: *mut usize) {
        present("count", count)?;
        // SAFETY: the caller gives room for `capacity` rows, or NULL to ask for the count alone.
        let out = unsafe { Output::optional("formats", formats, capacity, 0) }?;
        let found = self::formats();
        // SAFETY: checked above.
        unsafe { put(count, found.len()) };
        if let Some(out) = out {
            out.holds("formats", found.len())?.fill(found.iter().map(|(content, extension, can)| RlvCapabilityFormat {
                content: *content,
                can_read: u32::from(can[0]),
                can_write: u32::from(can[1]),
                can_write_bytes: u32::from(can[2]),
                extension: fixed(extension),
            }));
        }
        Ok(())
    }
}
