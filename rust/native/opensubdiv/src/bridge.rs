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

    /// How a cage of a [`Subdivision`] is subdivided, and its face-varying values.
    struct Rules<'a> {
        /// 0 Catmull-Clark, 1 Loop, 2 bilinear.
        scheme: u32,
        /// 0 edges and corners, 1 edges, 2 none.
        boundary: u32,
        /// 0 none, 1 corners only, 2 and 3 corners and junctions, 4 boundaries, 5 all.
        face_varying: u32,
        /// Whether sharpness is averaged along creases.
        chaikin: bool,
        /// Whether triangles of Catmull-Clark cages have weights of their own.
        smooth_triangles: bool,
        /// Number of values of each channel.
        channel_sizes: &'a [i32],
        /// For each channel the value of each corner of the cage.
        channel_corners: &'a [i32],
    }

    /// What is interpolated: values of `width` numbers each, one for each point of the cage or value of a channel.
    struct Primvar<'a> {
        /// 0 vertex, 1 varying, 2 face-varying.
        interpolation: u32,
        channel: u32,
        values: &'a [f32],
        width: u32,
    }

    /// A place: a face of the cage, which of its tiles, and parameters there, 0 to 1.
    #[derive(Clone, Copy, Debug, Default)]
    struct Spot {
        face: i32,
        part: i32,
        u: f32,
        v: f32,
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
        fn expected_sizes(cage: &Cage, first: u32, face_limit: f64, sizes: &mut [Sizes]) -> Result<()>;
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

        include!("opensubdiv/subdivision.h");

        type Subdivision;
        fn make_subdivision(cage: &Cage, rules: &Rules) -> Result<UniquePtr<Subdivision>>;
        fn evaluate(
            self: &Subdivision,
            primvar: &Primvar,
            spots: &[Spot],
            derivatives: u32,
            out: &mut [f32],
        ) -> Result<()>;

        fn osd_evaluate(cage: &Cage, rules: &Rules, primvar: &Primvar, spots: &[Spot], out: &mut [f32]) -> Result<()>;

        type Refined;
        fn refine_uniformly(cage: &Cage, rules: &Rules, level: u32) -> Result<UniquePtr<Refined>>;
        fn face_sizes(self: &Refined) -> &[u32];
        fn corners(self: &Refined) -> &[u32];
        fn parents(self: &Refined) -> &[u32];
        fn channel_corners(self: &Refined, channel: u32) -> Result<Vec<u32>>;
        fn values(self: &Refined, primvar: &Primvar) -> Result<Vec<f32>>;

        type BfrEvaluator<'a>;
        fn make_bfr<'a>(table: &'a Table, level: u32) -> Result<UniquePtr<BfrEvaluator<'a>>>;
        fn grid(self: Pin<&mut BfrEvaluator>, points: &[f32], size: u32, buffer: &mut [f32]) -> Result<u64>;
    }
}

// SAFETY: after construction the C++ object is only read, and OpenSubdiv's tables have no interior mutability.
unsafe impl Send for ffi::Table {}
// SAFETY: as above.
unsafe impl Sync for ffi::Table {}
// SAFETY: after construction it is only read, but for its cache of patches, which locks.
unsafe impl Send for ffi::Subdivision {}
// SAFETY: as above.
unsafe impl Sync for ffi::Subdivision {}
