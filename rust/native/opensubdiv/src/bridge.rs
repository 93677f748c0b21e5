//! The boundary to `cpp/opensubdiv`. Slices cross it without a copy, and every C++ exception becomes an error.

#[cxx::bridge(namespace = "relievo::opensubdiv")]
pub mod ffi {
    /// A control cage and how it is refined. Indices are checked, and every list is as long as its partner.
    struct Cage<'a> {
        point_count: u32,
        face_sizes: &'a [i32],
        corners: &'a [i32],
        /// Two for each crease.
        crease_points: &'a [i32],
        crease_sharpness: &'a [f32],
        sharp_points: &'a [i32],
        sharp_point_sharpness: &'a [f32],
        holes: &'a [i32],
        /// Whether boundary points of one face are smooth.
        round_corners: bool,
        /// 1 to 10.
        isolation: u32,
        single_crease: bool,
    }

    /// A patch of the adaptive table.
    struct Patch {
        /// Ptex face.
        tile: u32,
        /// Column and row in units of the patch's size, which is 2^-depth of the tile.
        u: u16,
        v: u16,
        depth: u8,
        /// Bit e: edge e is a boundary, and the points beyond it are phantoms.
        boundary: u8,
        /// 20 Gregory points rather than 16 of a B-spline.
        is_gregory: bool,
        /// One more than the creased edge of a single-crease patch, or 0.
        crease: u8,
        /// Sharpness of that crease at the patch's level.
        sharpness: f32,
        /// First index of its points.
        first: u32,
    }

    /// What a table is expected to hold.
    #[derive(Clone, Copy, Debug, Default)]
    struct Sizes {
        patches: f64,
        /// Weights of all stencils.
        weights: f64,
        /// Patches, where those with a crease are counted three times: a surface cuts them into as many pieces.
        pieces: f64,
    }

    // SAFETY: callers check every index and length before a call, as the comments of `table.h` state them; C++ borrows
    // slices for the call alone, and the slices it returns belong to the table.
    unsafe extern "C++" {
        include!("opensubdiv/table.h");

        type Table;
        fn expected_sizes(cage: &Cage, first: u32, sizes: &mut [Sizes]) -> Result<()>;
        /// Major * 10,000 + minor * 100 + patch of the headers.
        fn version_number() -> u32;
        fn refine(cage: &Cage) -> Result<UniquePtr<Table>>;
        fn tile_count(self: &Table) -> i32;
        fn patches(self: &Table) -> &[Patch];
        fn indices(self: &Table) -> &[i32];
        fn stencil_sizes(self: &Table) -> &[i32];
        fn stencil_indices(self: &Table) -> &[i32];
        fn stencil_weights(self: &Table) -> &[f64];
        fn evaluate(self: &Table, points: &[f64], tiles: &[i32], uv: &[f64], out: &mut [f64]) -> Result<()>;
        fn far_grid(self: &Table, points: &[f32], size: u32, buffer: &mut [f32]) -> Result<u64>;

        fn refine_and_evaluate(
            cage: &Cage,
            cage_points: &[f64],
            tiles: &[i32],
            uv: &[f64],
            out: &mut [f64],
        ) -> Result<()>;

        type BfrEvaluator<'a>;
        fn make_bfr<'a>(table: &'a Table, level: u32) -> Result<UniquePtr<BfrEvaluator<'a>>>;
        fn grid(self: Pin<&mut BfrEvaluator>, points: &[f32], size: u32, buffer: &mut [f32]) -> Result<u64>;
    }
}

// SAFETY: after construction the C++ object is only read, and OpenSubdiv's tables have no interior mutability.
unsafe impl Send for ffi::Table {}
// SAFETY: as above.
unsafe impl Sync for ffi::Table {}
