//! The functions of `cpp/openmesh/library.h` and `cpp/openmesh/patch.h`.

#[cxx::bridge(namespace = "relievo::openmesh")]
pub mod ffi {
    unsafe extern "C++" {
        include!("openmesh/library.h");
        include!("openmesh/patch.h");

        fn open_library(file: &str) -> Result<()>;

        type Patch;

        fn new_patch() -> Result<UniquePtr<Patch>>;
        fn copy(self: &Patch) -> Result<UniquePtr<Patch>>;
        fn vertex_count(self: &Patch) -> usize;
        fn face_count(self: &Patch) -> usize;
        fn add_vertices(self: Pin<&mut Patch>, points: &[f32]) -> Result<()>;
        fn add_faces(self: Pin<&mut Patch>, triangles: &[u32], made: &mut Vec<u32>) -> Result<()>;
        fn points(self: &Patch, vertices: &[u32], out: &mut [f32]) -> Result<()>;
        fn set_points(self: Pin<&mut Patch>, vertices: &[u32], points: &[f32]) -> Result<()>;
        fn edges(self: &Patch, out: &mut [u32]) -> Result<usize>;
        fn edge_slots(self: &Patch) -> usize;
        fn split_edges(self: Pin<&mut Patch>, edges: &[u32], points: &[f32], made: &mut Vec<u32>) -> Result<()>;
        fn split_faces(self: Pin<&mut Patch>, faces: &[u32], points: &[f32], made: &mut Vec<u32>) -> Result<()>;
        fn flip_edges(self: Pin<&mut Patch>, edges: &[u32], done: &mut [u8]) -> Result<()>;
        fn collapse_edges(self: Pin<&mut Patch>, edges: &[u32], done: &mut [u8]) -> Result<()>;
        fn remove_faces(self: Pin<&mut Patch>, faces: &[u32]) -> Result<()>;
        fn boundary_loops(self: &Patch, sizes: &mut Vec<u32>, vertices: &mut Vec<u32>) -> Result<()>;
        fn components(self: &Patch) -> Result<usize>;
        fn euler_number(self: &Patch) -> Result<i64>;
        fn read(
            self: &Patch,
            points: &mut Vec<f32>,
            triangles: &mut Vec<u32>,
            old_vertices: &mut Vec<u32>,
            old_faces: &mut Vec<u32>,
        ) -> Result<()>;
    }
}
