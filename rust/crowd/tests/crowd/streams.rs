//! Clusters that are read while a model is drawn.

use relievo_core::{Context, ErrorKind};
use relievo_crowd::{CrowdModel, NONE, Stream};
use relievo_testing::Random;

use crate::arm::built;
use crate::cuts::{borders, places};

fn saved(model: &CrowdModel) -> (tempfile::TempDir, std::path::PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("arm.rcrowd");
    model.save(&path).unwrap();
    (folder, path)
}

/// Checks that what is shown in place of a cut is in memory and closed, and returns its number of triangles.
fn closed(stream: &Stream, places: &[u32], cut: &[u32]) -> usize {
    let shown = stream.shown(cut);
    let triangles: Vec<[u32; 3]> =
        shown.iter().flat_map(|cluster| stream.triangles(*cluster).expect("it is in memory").0).copied().collect();
    let open = borders(places, triangles.iter());
    assert!(open.is_empty(), "{open:?}");
    triangles.len()
}

#[test]
fn what_is_shown_is_closed_and_within_the_budget_and_becomes_the_cut() {
    let model = built(60, 24);
    let places = places(&model.character);
    let (_folder, path) = saved(&model);
    let budget = 16 * u64::from(model.input_triangles) / 2;
    let mut stream = Stream::open(&Context::serial(), &path, budget).unwrap();
    let levels = model.levels(3);
    let (fine, coarse) = (levels[1].1.clone(), &levels[2].1);
    let goal = model.triangle_count(&fine) as usize;
    assert!(16 * goal as u64 <= budget && goal > 300);
    let mut counts = vec![closed(&stream, &places, &fine)];
    loop {
        let done = stream.request(&fine, 1).unwrap();
        assert!(done.read <= 1 && stream.bytes() <= budget);
        counts.push(closed(&stream, &places, &fine));
        if done.missing == 0 {
            break;
        }
    }
    assert!(counts.len() > 10 && counts[0] * 8 < goal && counts.last() == Some(&goal), "{counts:?}");
    assert_eq!(stream.shown(&fine), fine);
    for cluster in &fine {
        assert_eq!(stream.triangles(*cluster).unwrap().0, model.triangles(*cluster));
    }
    // The whole input does not fit: it is shown as far as the budget goes.
    let input = model.input_clusters();
    let done = stream.request(&input, u32::MAX).unwrap();
    assert!(done.missing > 0 && done.dropped > 0 && stream.bytes() <= budget, "{done:?}");
    assert!(closed(&stream, &places, &input) < input.len() * 40);
    // What was dropped comes back.
    stream.request(coarse, u32::MAX).unwrap();
    assert_eq!(&stream.shown(coarse), coarse);
}

#[test]
fn random_requests_leave_no_cracks() {
    let model = built(40, 20);
    let places = places(&model.character);
    let (_folder, path) = saved(&model);
    let mut stream = Stream::open(&Context::serial(), &path, 16 * 600).unwrap();
    let mut random = Random(11);
    for _ in 0..150 {
        let cut = model.cut(model.size() * 0.05 * random.unit() * random.unit());
        let done = stream.request(&cut, 1 + random.below(6) as u32).unwrap();
        assert!(stream.bytes() <= 16 * 600);
        let count = closed(&stream, &places, &cut);
        assert!(count > 0 && (done.missing > 0 || count as u64 == model.triangle_count(&cut)));
    }
}

#[test]
fn small_budgets_and_missing_clusters_are_refused() {
    let model = built(12, 8);
    let (_folder, path) = saved(&model);
    let roots = model.clusters.iter().filter(|cluster| cluster.used_by == NONE).map(|cluster| u64::from(cluster.count));
    let needed = 16 * roots.sum::<u64>();
    assert_eq!(Stream::open(&Context::serial(), &path, needed - 1).unwrap_err().kind, ErrorKind::Memory);
    let mut stream = Stream::open(&Context::serial(), &path, needed).unwrap();
    assert!(stream.request(&[model.clusters.len() as u32], 1).is_err());
    // Nothing else fits.
    let done = stream.request(&model.input_clusters(), 9).unwrap();
    assert_eq!((done.read, done.dropped), (0, 0));
}
