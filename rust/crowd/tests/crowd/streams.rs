//! Clusters that are read while a crowd is drawn.

use std::path::PathBuf;
use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3};
use relievo_core::progress::Silent;
use relievo_core::{Context, ErrorKind};
use relievo_crowd::{
    Agent, Blend, BuildSettings, Crowd, CrowdModel, CrowdView, DeviceCrowd, DrawList, Drawn, Frame, NONE, Stream,
};
use relievo_testing::{Random, device};

use crate::arm::{arm, built};
use crate::cuts::{borders, places};

/// A model and its file.
struct Saved {
    model: Arc<CrowdModel>,
    folder: tempfile::TempDir,
}

impl Saved {
    fn new(rings: usize, sides: usize) -> Self {
        Self::of(built(rings, sides))
    }

    /// A model of so small clusters that several levels have groups, not only one of the whole surface.
    fn of_many_groups() -> Self {
        let settings = BuildSettings { cluster_triangles: 8, group_clusters: 4, ..BuildSettings::default() };
        let source = arm(60, 32);
        Self::of(CrowdModel::build(&Context::serial(), &source, &[0], &settings, &mut Silent).unwrap())
    }

    fn of(model: CrowdModel) -> Self {
        let saved = Self { model: Arc::new(model), folder: tempfile::tempdir().unwrap() };
        saved.model.save(&saved.path()).unwrap();
        saved
    }

    fn path(&self) -> PathBuf {
        self.folder.path().join("arm.rcrowd")
    }

    /// Returns a crowd that reads clusters and one that has them all, with agents at these distances from the origin.
    fn crowds(&self, budget: u64, most_read: u32, away: &[f64]) -> (Crowd, Crowd) {
        let stream = Stream::open(&Context::serial(), &[self.path()], budget, most_read).unwrap();
        assert!(stream.bytes() <= budget);
        let (mut crowd, mut whole) = (Crowd::streamed(stream), Crowd::new(vec![self.model.clone()]));
        for away in away {
            let transform = DAffine3::from_translation(DVec3::new(0.1 * away, -1.0, -away));
            let agent = Agent { model: 0, clip: 0, phase: 0.1 * away, transform };
            crowd.add(agent).unwrap();
            whole.add(agent).unwrap();
        }
        (crowd, whole)
    }
}

fn view(tolerance: f32) -> CrowdView {
    CrowdView::perspective(DVec3::ZERO, DMat3::IDENTITY, 0.9, [1280, 720], tolerance).unwrap()
}

fn cut(crowd: &mut Crowd, view: &CrowdView) -> Frame {
    let mut frame = Frame::default();
    crowd.cut(&Context::serial(), view, &mut frame).unwrap();
    frame
}

/// Checks that what is drawn of every agent is in memory and closed. Returns the number of triangles.
fn closed(crowd: &Crowd, saved: &Saved, frame: &Frame) -> u64 {
    let places = places(&saved.model.character);
    let mut count = 0;
    for drawn in &frame.drawn {
        let mut triangles = Vec::new();
        for cluster in crowd.clusters(frame, *drawn) {
            let of = crowd.stream().unwrap().triangles(0, *cluster).expect("it is in memory").0;
            assert_eq!(of, saved.model.triangles(*cluster));
            triangles.extend(of);
        }
        let open = borders(&places, triangles.iter());
        assert!(open.is_empty(), "{open:?}");
        count += triangles.len() as u64;
    }
    assert_eq!(count, frame.triangles);
    count
}

#[test]
fn what_is_drawn_is_closed_and_becomes_the_cut() {
    let saved = Saved::new(60, 24);
    let (mut crowd, mut whole) = saved.crowds(1 << 20, 1, &[4.0, 9.0, 300.0, 320.0]);
    let view = view(0.5);
    let goal = cut(&mut whole, &view);
    assert!(goal.drawn.iter().any(|it| matches!(it.1, Drawn::Step(_))) && !goal.mixed.is_empty());
    let mut counts = Vec::new();
    loop {
        let frame = cut(&mut crowd, &view);
        counts.push(closed(&crowd, &saved, &frame));
        let read = crowd.stream().unwrap().counts();
        assert!(read.read <= 1 && read.wanted_triangles == goal.triangles, "{read:?}");
        if read.missing == 0 {
            assert_eq!((frame.drawn, frame.mixed, frame.triangles), (goal.drawn, goal.mixed, goal.triangles));
            break;
        }
    }
    assert!(counts.len() > 10 && counts[0] * 4 < goal.triangles, "{counts:?}");
    assert!(counts.is_sorted(), "what is drawn becomes coarser: {counts:?}");
    counts.dedup();
    assert!(counts.len() > 10, "it becomes finer by leaps: {counts:?}");
}

#[test]
fn a_budget_of_twice_the_clusters_of_a_view_is_enough_for_any_number_of_reads() {
    for saved in [Saved::new(60, 24), Saved::of_many_groups()] {
        let largest = saved.model.clusters.iter().map(|cluster| u64::from(cluster.count)).max().unwrap();
        let roots = saved.model.clusters.iter().filter(|cluster| cluster.used_by == NONE).count() as u64;
        let view = view(0.5);
        let (_, mut whole) = saved.crowds(1 << 20, 1, &[3.0]);
        let goal = cut(&mut whole, &view);
        let (mut crowd, _) = saved.crowds(16 * largest * (2 * goal.clusters + roots), 3, &[3.0]);
        let frames = (0..2000).position(|_| {
            cut(&mut crowd, &view);
            crowd.stream().unwrap().counts().missing == 0
        });
        assert!(frames.is_some_and(|frames| frames as u64 <= goal.clusters), "{frames:?} for {}", goal.clusters);
    }
}

#[test]
fn random_views_leave_no_cracks_within_any_budget() {
    check_random_views(&Saved::new(40, 20), (16 * 1200, 7), &[3.0, 5.0, 40.0]);
    check_random_views(&Saved::of_many_groups(), (16 * 3000, 90), &[1.5, 5.0, 40.0]);
}

fn check_random_views(saved: &Saved, (budget, most_read): (u64, u32), away: &[f64]) {
    let (mut crowd, mut whole) = saved.crowds(budget, most_read, away);
    let mut random = Random(11);
    let mut complete = 0;
    for _ in 0..150 {
        let mut view = view(40.0 * random.unit() * random.unit() + 0.1);
        // What is beside the picture is closed too.
        view.planes.clear();
        let frame = cut(&mut crowd, &view);
        let count = closed(&crowd, saved, &frame);
        let goal = cut(&mut whole, &view).triangles;
        assert!(count > 0 && count <= goal);
        if crowd.stream().unwrap().counts().missing == 0 {
            complete += 1;
            assert_eq!(count, goal);
        }
    }
    assert!(complete > 5 && complete < 150, "{complete}");
}

#[test]
fn a_budget_that_is_too_small_is_used_well() {
    let saved = Saved::new(60, 24);
    let input = u64::from(saved.model.input_triangles);
    let (mut crowd, mut whole) = saved.crowds(16 * input / 2, u32::MAX, &[3.0]);
    let view = view(0.01);
    let frame = cut(&mut crowd, &view);
    let goal = cut(&mut whole, &view).triangles;
    let counts = crowd.stream().unwrap().counts();
    assert!(counts.missing > 0 && counts.resident <= crowd.stream().unwrap().slot_count(), "{counts:?}");
    let count = closed(&crowd, &saved, &frame);
    // Slots that are not full take the rest.
    assert!(goal == input && count * 4 > input, "{count} of {goal}");
    // Nothing leaves memory while the view stays.
    let again = cut(&mut crowd, &view);
    assert_eq!((again.mixed, crowd.stream().unwrap().counts().dropped), (frame.mixed, 0));
}

#[test]
fn draws_refer_to_slots_that_a_host_mirrors() {
    let saved = Saved::new(40, 20);
    let (mut crowd, _) = saved.crowds(16 * 1000, 20, &[3.0, 5.0, 200.0, 210.0]);
    let mirror = |crowd: &Crowd, indices: &mut Vec<[u32; 3]>| {
        let stream = crowd.stream().unwrap();
        indices.resize(stream.slot_count() as usize * stream.slot_triangles() as usize, [NONE; 3]);
        for [model, cluster] in stream.read() {
            let first = stream.slot(*model, *cluster).unwrap() * stream.slot_triangles();
            let triangles = stream.triangles(*model, *cluster).unwrap().0;
            indices[first as usize..][..triangles.len()].copy_from_slice(triangles);
        }
    };
    let mut indices = Vec::new();
    // What opening has read.
    mirror(&crowd, &mut indices);
    let mut draws = DrawList::default();
    let mut dropped = 0;
    for round in 0..40 {
        let frame = cut(&mut crowd, &view([0.1, 1.0, 4.0, 30.0][round / 10 % 4]));
        mirror(&crowd, &mut indices);
        dropped += crowd.stream().unwrap().counts().dropped;
        draws.update(&crowd, &frame, 0.0).unwrap();
        assert!(!draws.draws.is_empty());
        for (draw, [_, cluster]) in draws.draws.iter().zip(&draws.clusters) {
            let drawn = &indices.as_flattened()[draw.first_index as usize..][..draw.index_count as usize];
            assert_eq!(drawn, saved.model.triangles(*cluster).as_flattened());
        }
    }
    assert!(dropped > 0);
}

#[test]
fn a_stream_has_no_impostors_and_moving_vertices_keep_their_way() {
    let saved = Saved::new(40, 20);
    let (mut crowd, mut whole) = saved.crowds(1 << 20, 9, &[3.0, 2500.0]);
    let mut view = view(2.0);
    view.impostors = true;
    assert_eq!(cut(&mut whole, &view).impostors(), [1]);
    let frame = cut(&mut crowd, &view);
    assert!(frame.impostors().is_empty());
    closed(&crowd, &saved, &frame);
    (view.impostors, view.geomorph) = (false, true);
    let goal = cut(&mut whole, &view);
    let mut frame = cut(&mut crowd, &view);
    while crowd.stream().unwrap().counts().missing > 0 {
        assert_eq!(frame.blends.len(), frame.mixed.len());
        frame = cut(&mut crowd, &view);
    }
    assert!(goal.blends.iter().any(|blend| *blend > 0.0));
    assert_eq!((frame.mixed, frame.blends), (goal.mixed, goal.blends));
}

#[test]
fn agents_of_a_step_are_instances_of_the_same_coarser_clusters() {
    let saved = Saved::new(60, 24);
    let (mut crowd, _) = saved.crowds(16 * 700, 1, &[60.0, 60.001, 60.002, 60.003]);
    let frame = cut(&mut crowd, &view(0.01));
    assert!(crowd.stream().unwrap().counts().missing > 0);
    let mut draws = DrawList::default();
    draws.update(&crowd, &frame, 0.0).unwrap();
    assert!(draws.draws.iter().all(|draw| draw.instance_count == 4), "{:?}", draws.draws);
}

#[test]
fn models_share_a_budget() {
    let (small, large) = (Saved::new(12, 8), Saved::new(60, 24));
    let paths = [small.path(), large.path()];
    let mut crowd = Crowd::streamed(Stream::open(&Context::serial(), &paths, 1 << 20, u32::MAX).unwrap());
    for model in [0, 1] {
        let transform = DAffine3::from_translation(DVec3::new(f64::from(model), -1.0, -4.0));
        crowd.add(Agent { model, clip: 0, phase: 0.0, transform }).unwrap();
    }
    let frame = cut(&mut crowd, &view(0.1));
    assert_eq!(crowd.stream().unwrap().counts().missing, 0);
    for (drawn, saved) in frame.drawn.iter().zip([&small, &large]) {
        for cluster in crowd.clusters(&frame, *drawn) {
            assert_eq!(crowd.triangles(drawn.0, *cluster).0, saved.model.triangles(*cluster));
        }
    }
}

#[test]
fn small_budgets_damaged_clusters_and_work_on_whole_models_are_refused() {
    let saved = Saved::new(40, 20);
    let context = Context::serial();
    let open = |budget| Stream::open(&context, &[saved.path()], budget, 9);
    let model = &saved.model;
    let largest = model.clusters.iter().map(|cluster| u64::from(cluster.count)).max().unwrap();
    let roots = model.clusters.iter().filter(|cluster| cluster.used_by == NONE).count() as u64;
    assert_eq!(open(16 * largest * roots - 1).unwrap_err().kind, ErrorKind::Memory);
    assert_eq!(open(16 * largest * roots).unwrap().slot_count() as u64, roots);
    assert!(Stream::open::<PathBuf>(&context, &[], 1 << 20, 9).is_err());

    let (crowd, _) = saved.crowds(1 << 20, 9, &[3.0]);
    let streamed = &crowd.models()[0];
    let path = saved.folder.path().join("other.rcrowd");
    assert_eq!(streamed.save(&path).unwrap_err().kind, ErrorKind::Unsupported);
    assert!(!path.exists());
    let unstreamed = Crowd::new(vec![streamed.clone()]);
    if let Some(device) = device() {
        assert!(DeviceCrowd::new(&device, &unstreamed, 1).is_err() && DeviceCrowd::new(&device, &crowd, 1).is_err());
    }
    assert!(streamed.with_blend(&context, Blend::DualQuaternion).is_err());
    assert!(streamed.mesh(&context, &[0], &streamed.clips[0].poses[0]).is_err());

    // The last chunk of the file is the first cluster, of the input.
    let mut bytes = std::fs::read(saved.path()).unwrap();
    *bytes.last_mut().unwrap() ^= 1;
    std::fs::write(saved.path(), bytes).unwrap();
    let (mut crowd, _) = saved.crowds(1 << 20, u32::MAX, &[3.0]);
    let error = crowd.cut(&context, &view(0.001), &mut Frame::default()).unwrap_err();
    assert!(error.to_string().contains("cluster 0"), "{error}");
    // Coarser cuts are still drawn.
    let frame = cut(&mut crowd, &view(50.0));
    closed(&crowd, &saved, &frame);
}
