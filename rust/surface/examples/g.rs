use relievo_core::*;
use relievo_surface::*;
fn main() {
    let c = Context::serial();
    let n = 16u32;
    let mut pts = vec![];
    let mut cor = vec![];
    for j in 0..=n {
        for i in 0..=n {
            pts.push([i as f32, j as f32, (i * j % 7) as f32]);
            if i < n && j < n {
                let a = j * (n + 1) + i;
                cor.extend([a, a + 1, a + n + 2, a + n + 1]);
            }
        }
    }
    let s = Surface::new(&c, &Mesh::new(pts, vec![4; (n * n) as usize], cor), &SurfaceOptions::default()).unwrap();
    let mut out = Samples::default();
    let g = Grid::whole(128, Placement::Centred);
    for level in [simd::Level::Baseline, simd::Level::Avx2, simd::Level::Avx512] {
        for _ in 0..2 {
            let t = std::time::Instant::now();
            for _ in 0..20 {
                for tile in 0..256 {
                    s.grid(level, tile, &g, Order::First, &mut out);
                }
            }
            let dt = t.elapsed().as_secs_f64();
            println!("{level:?} {:.1} M/s", 20.0 * 256.0 * 16384.0 / dt / 1e6);
        }
    }
}
