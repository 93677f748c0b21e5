//! Layers that fade: documents that are opened again go on fading as if they had never been closed, histories restore
//! stamps to the bit, and full budgets lose what is oldest. On Catmull-Clark surfaces and on triangle meshes.

use std::sync::Arc;

use glam::{DAffine3, DVec3, Vec4};
use relievo_core::{Context, ContextOptions, Mesh};
use relievo_detail::{
    Action, Brush, Dab, DabReport, DecayingObject, DisplacedObject, Falloff, History, LayeredObject, PaintMode,
    Recorded, SculptMode, TriangleObject,
};
use relievo_document::{Document, Kind, PageFile, Settings};
use relievo_surface::{Surface, SurfaceOptions, TriangleSurface};
use relievo_testing::{Random, grid};
use relievo_tiles::triangle::{TriangleChannel, TriangleOptions};
use relievo_tiles::{ChannelOptions, DecayOptions, Displacement, Paint};

use crate::triangle_ridges::check_closed;

const LIMIT: u64 = 1 << 30;
const DECAY: DecayOptions = DecayOptions { delay: 1.0, duration: 6.0 };

const COLOR: Vec4 = Vec4::new(0.5, 0.25, 0.125, 1.0);

/// What fades: an object over either kind of surface.
trait Subject: LayeredObject {
    fn mesh() -> Mesh;

    /// Eight faces in a row, of which those of triangles do not touch.
    fn row() -> Mesh;

    /// An object that can be painted, with colours of half floats if `halves`, without decay.
    fn made(context: &Context, mesh: &Mesh, budget: u64, halves: bool) -> Self;

    fn bare(context: &Context, mesh: &Mesh, budget: u64) -> Self {
        Self::made(context, mesh, budget, false)
    }

    /// Bytes of `count` tiles or faces of a kind, and of stamps of displacement.
    fn room(&self, kind: Kind, count: u64) -> u64;

    fn stamp_room(&self, count: u64) -> u64;

    /// The tiles or faces that have displacement.
    fn allocated(&self) -> Vec<u32>;

    /// Bytes of displacement in memory, and blocks of it on pages.
    fn resident(&self) -> [u64; 2];

    fn dab(&mut self, context: &Context, dab: &Dab) -> DabReport;

    fn empty(mesh: &Mesh) -> Document;

    /// What is seen.
    fn store_seen(&self, context: &Context, document: &mut Document);

    /// Bytes of displacement and colours.
    fn bytes(&self) -> u64;
}

/// Writes the methods of a subject that are the same for the channels of both kinds of objects.
macro_rules! what_is_seen {
    () => {
        fn store_seen(&self, context: &Context, document: &mut Document) {
            self.displacement().field().store(context, document, "displacement").unwrap();
            match (self.paint(), self.half_paint()) {
                (Some(paint), _) => paint.field().store(context, document, "colour").unwrap(),
                (_, paint) => paint.unwrap().field().store(context, document, "colour").unwrap(),
            }
        }

        fn bytes(&self) -> u64 {
            self.displacement().bytes() + self.paint().unwrap().bytes()
        }
    };
}

impl Subject for DisplacedObject {
    fn mesh() -> Mesh {
        grid(4, false, &[2, 2, 1, 2, 0, 2], false)
    }

    fn row() -> Mesh {
        let points = (0..18).map(|i| [(i / 2) as f32, (i % 2) as f32, 0.0]).collect();
        let corners = (0..8).flat_map(|i| [2 * i, 2 * i + 2, 2 * i + 3, 2 * i + 1]).collect();
        Mesh::new(points, vec![4; 8], corners)
    }

    fn made(context: &Context, mesh: &Mesh, budget: u64, halves: bool) -> Self {
        let surface = Surface::new(context, mesh, &SurfaceOptions::default()).unwrap();
        let options = ChannelOptions { size: 16, budget, ..ChannelOptions::default() };
        let topology = surface.topology().clone();
        let displacement = Displacement::new(topology.clone(), &options).unwrap();
        let placed = DisplacedObject::new(context, surface, &mesh.points, displacement, DAffine3::IDENTITY);
        let mut object = placed.unwrap();
        match halves {
            true => object.set_half_paint(Paint::of_color(topology, COLOR, &options).unwrap()).unwrap(),
            false => object.set_paint(Paint::of_color(topology, COLOR, &options).unwrap()).unwrap(),
        }
        object
    }

    fn room(&self, kind: Kind, count: u64) -> u64 {
        let tile = match kind {
            Kind::Scalar => self.displacement().field().tile_bytes(0),
            Kind::Rgba8 => self.paint().unwrap().field().tile_bytes(0),
            _ => self.half_paint().unwrap().field().tile_bytes(0),
        };
        count * tile
    }

    fn stamp_room(&self, count: u64) -> u64 {
        3 * self.room(Kind::Scalar, count)
    }

    fn allocated(&self) -> Vec<u32> {
        self.displacement().field().allocated().collect()
    }

    fn resident(&self) -> [u64; 2] {
        [self.displacement().resident_bytes(), self.displacement().paged_count() as u64]
    }

    fn dab(&mut self, context: &Context, dab: &Dab) -> DabReport {
        dab.apply(context, self).unwrap()
    }

    fn empty(mesh: &Mesh) -> Document {
        Document::new(mesh, "baseline").unwrap()
    }

    what_is_seen!();
}

impl Subject for TriangleObject {
    fn mesh() -> Mesh {
        let side = 5u32;
        let points = (0..side * side).map(|k| [(k % side) as f32, (k / side) as f32, 0.0]).collect();
        let triangles: Vec<[u32; 3]> = (0..16)
            .map(|k| k / 4 * side + k % 4)
            .flat_map(|a| [[a, a + 1, a + side + 1], [a, a + side + 1, a + side]])
            .collect();
        Mesh::from_triangles(points, &triangles)
    }

    fn row() -> Mesh {
        let corners = [[0.05, 0.1], [0.95, 0.1], [0.5, 0.95]];
        let points = (0..24).map(|i| [corners[i % 3][0] + (i / 3) as f32, corners[i % 3][1], 0.0]).collect();
        let triangles: Vec<[u32; 3]> = (0..8).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        Mesh::from_triangles(points, &triangles)
    }

    fn made(context: &Context, mesh: &Mesh, budget: u64, halves: bool) -> Self {
        let surface = TriangleSurface::new(context, mesh).unwrap();
        let topology = surface.topology().clone();
        let options = TriangleOptions { segments: 16, budget };
        let displacement = TriangleChannel::displacement(topology.clone(), &options).unwrap();
        let mut object = TriangleObject::new(context, surface, displacement, DAffine3::IDENTITY).unwrap();
        match halves {
            true => object.set_half_paint(TriangleChannel::of_color(topology, COLOR, &options).unwrap()).unwrap(),
            false => object.set_paint(TriangleChannel::of_color(topology, COLOR, &options).unwrap()).unwrap(),
        }
        object
    }

    fn room(&self, kind: Kind, count: u64) -> u64 {
        let vertices = self.surface().topology().vertex_count() as u64;
        kind.texel() as u64 * (vertices + count * (169 + 3 * 15))
    }

    fn stamp_room(&self, count: u64) -> u64 {
        3 * self.room(Kind::Scalar, count)
    }

    fn allocated(&self) -> Vec<u32> {
        self.displacement().field().allocated().collect()
    }

    fn resident(&self) -> [u64; 2] {
        [self.displacement().resident_bytes(), self.displacement().paged().len() as u64]
    }

    fn dab(&mut self, context: &Context, dab: &Dab) -> DabReport {
        TriangleObject::dab(self, context, dab).unwrap()
    }

    fn empty(mesh: &Mesh) -> Document {
        Document::of_triangles(mesh, "baseline").unwrap()
    }

    what_is_seen!();
}

/// Fading as a whole, or in one layer of each kind over others that stay.
fn object<O: Subject>(context: &Context, mesh: &Mesh, layered: bool) -> O {
    let mut object = O::bare(context, mesh, LIMIT);
    if !layered {
        object.set_decay(DECAY, LIMIT).unwrap();
        return object;
    }
    for (kind, name, opacity, size) in [(Kind::Scalar, "tracks", 0.5, 8), (Kind::Rgba8, "frost", 1.0, 32)] {
        let settings = Settings { opacity, ..Settings::of(kind) };
        let (id, _) = object.add_layer(context, kind, name, settings, size).unwrap();
        object.set_layer_decay(context, id, Some(DECAY), LIMIT).unwrap();
    }
    object
}

fn dab(random: &mut Random) -> Dab {
    dab_above(random, 0.0)
}

/// A dab whose centre has at least so large a y.
fn dab_above(random: &mut Random, low: f64) -> Dab {
    let mut place = || 4.0 * f64::from(random.unit());
    let center = DVec3::new(place(), place().max(low), 0.0);
    let half = DVec3::new(0.4, 0.4, 1.0) * (0.5 + f64::from(random.unit()));
    let brush = Brush::on_surface(center, DVec3::Z, DVec3::X, half, Falloff::Smooth).unwrap();
    let color = [random.unit(), random.unit(), random.unit(), 1.0];
    let action = match random.below(5) {
        0 | 1 => Action::Paint { mode: PaintMode::Mix, color },
        2 => Action::Paint { mode: PaintMode::Erase, color },
        3 => Action::Sculpt { mode: SculptMode::Erase, height: 0.0 },
        _ => Action::Sculpt { mode: SculptMode::Draw, height: 0.1 },
    };
    Dab { brush, action, strength: 1.0 }
}

fn document<O: Subject>(context: &Context, mesh: &Mesh, object: &mut O) -> Document {
    object.states(context).unwrap();
    let mut document = O::empty(mesh);
    object.store(context, &mut document).unwrap();
    document
}

/// All layers, their stamps, the time, and what is seen.
fn state<O: Subject>(context: &Context, mesh: &Mesh, object: &mut O) -> [Vec<u8>; 2] {
    let layers = document(context, mesh, object).to_bytes().unwrap();
    let mut seen = O::empty(mesh);
    object.store_seen(context, &mut seen);
    [layers, seen.to_bytes().unwrap()]
}

/// The stamps alone.
fn stamps<O: Subject>(context: &Context, mesh: &Mesh, object: &mut O) -> Vec<(u32, u32, Vec<u8>)> {
    let document = document(context, mesh, object);
    let layers = document.layers().iter().filter(|layer| layer.kind() == Kind::Stamps);
    let blocks = layers.flat_map(|layer| {
        let unpacked = |at: usize| layer.unpack(document.topology(), at).unwrap();
        (0..layer.blocks().len()).map(move |at| (layer.id(), layer.blocks()[at].tile(), unpacked(at)))
    });
    blocks.collect()
}

#[test]
fn documents_that_are_opened_again_fade_as_if_they_had_never_been_closed() {
    opened_again::<DisplacedObject>();
    opened_again::<TriangleObject>();
}

fn opened_again<O: Subject>() {
    let (context, mesh) = (Context::serial(), O::mesh());
    for layered in [false, true] {
        let mut random = Random(3);
        let [mut whole, mut parts]: [O; 2] = [(); 2].map(|()| object(&context, &mesh, layered));
        let bytes = whole.bytes();
        let (mut saved, mut stamped) = (0, 0);
        for frame in 0..60 {
            let time = 0.25 * f64::from(frame);
            let dab = (frame < 30).then(|| dab(&mut random));
            for object in [&mut whole, &mut parts] {
                object.advance(&context, time).unwrap();
                if let Some(dab) = &dab {
                    object.dab(&context, dab);
                }
                object.settle(&context).unwrap();
                assert!(object.stamp(&context).unwrap().is_empty());
            }
            let [a, b] = [&mut whole, &mut parts].map(|object| state(&context, &mesh, object));
            assert!(a == b, "{layered} {frame}");
            stamped = stamped.max(stamps(&context, &mesh, &mut whole).len());
            if frame % 7 == 5 {
                let file = document(&context, &mesh, &mut parts).to_bytes().unwrap();
                let document = Document::parse(&file, LIMIT).unwrap();
                parts = O::bare(&context, &mesh, LIMIT);
                assert!(parts.take_up(&context, &document, LIMIT).unwrap().is_empty());
                for name in ["tracks", "frost"] {
                    if let Some(id) = parts.layer(name) {
                        parts.set_active_layer(&context, id).unwrap();
                    }
                }
                assert_eq!(parts.time(), time);
                let reopened = state(&context, &mesh, &mut parts);
                assert!(reopened == a, "{layered} {frame}");
                saved += 1;
            }
        }
        assert!(stamped > 10 && saved > 7);
        assert!(stamps(&context, &mesh, &mut whole).is_empty(), "all has faded");
        assert_eq!(whole.bytes(), bytes);
    }
}

/// What histories restore: all layers; and with one plain layer what is seen, which is then that layer. Corners of
/// composites are rounded in the order in which tiles changed.
fn restored<O: Subject>(context: &Context, mesh: &Mesh, object: &mut O, layered: bool) -> Vec<Vec<u8>> {
    state(context, mesh, object).into_iter().take(if layered { 1 } else { 2 }).collect()
}

#[test]
fn undo_restores_stamps_whatever_has_faded_since() {
    undone::<DisplacedObject>();
    undone::<TriangleObject>();
}

fn undone<O: Subject>() {
    let (context, mesh) = (Context::serial(), O::mesh());
    for layered in [false, true] {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.relievo");
        let mut random = Random(8);
        let dabs: Vec<Dab> = (0..24).map(|_| dab(&mut random)).collect();
        let time = |edit: usize| 0.1 * edit as f64;
        let mut object: O = object(&context, &mesh, layered);
        let bytes = object.bytes();
        let mut history = History::new(LIMIT);
        history.save(&path, &document(&context, &mesh, &mut object)).unwrap();
        let mut before = vec![stamps(&context, &mesh, &mut object)];
        let make = |object: &mut O, edit: usize| {
            object.advance(&context, time(edit)).unwrap();
            object.dab(&context, &dabs[edit]);
        };
        for edit in 0..dabs.len() {
            object.advance(&context, time(edit)).unwrap();
            history.begin(&context, &mut object, "dab").unwrap();
            object.dab(&context, &dabs[edit]);
            if history.end(&context, &mut object).unwrap().is_some() {
                before.push(stamps(&context, &mesh, &mut object));
            }
        }
        assert!(before.len() > 18);
        // At once, and after some of it has faded.
        for now in [time(dabs.len() - 1), 4.5] {
            object.advance(&context, now).unwrap();
            let there = restored(&context, &mesh, &mut object, layered);
            for edit in (0..before.len() - 1).rev() {
                history.undo(&context, &mut object).unwrap().unwrap();
                assert!(stamps(&context, &mesh, &mut object) == before[edit], "{layered} {now} {edit}");
            }
            while history.redo(&context, &mut object).unwrap().is_some() {}
            assert!(restored(&context, &mesh, &mut object, layered) == there, "{layered} {now}");
        }
        // What is left is what would be if the last edits had never been made.
        for _ in 0..6 {
            history.undo(&context, &mut object).unwrap().unwrap();
        }
        let count = before.len() - 1 - 6;
        let mut other: O = self::object(&context, &mesh, layered);
        let mut made = 0;
        for edit in 0..dabs.len() {
            let there = stamps(&context, &mesh, &mut other);
            make(&mut other, edit);
            made += usize::from(stamps(&context, &mesh, &mut other) != there);
            if made == count {
                break;
            }
        }
        other.advance(&context, 4.5).unwrap();
        let [a, b] = [&mut object, &mut other].map(|object| restored(&context, &mesh, object, layered));
        assert!(a == b, "{layered}");
        drop(history);
        // So does the journal, whose edits come to the time of the object.
        let (document, mut history) = History::open(&path, LIMIT, LIMIT).unwrap();
        let mut opened = O::bare(&context, &mesh, LIMIT);
        opened.take_up(&context, &document, LIMIT).unwrap();
        opened.advance(&context, 4.5).unwrap();
        let [a, b] = [&mut object, &mut opened].map(|object| restored(&context, &mesh, object, layered));
        assert!(a == b, "{layered}");
        assert_eq!((history.undo_count(), history.redo_count()), (count, 6));
        history.redo(&context, &mut opened).unwrap().unwrap();
        assert!(stamps(&context, &mesh, &mut opened) == before[count + 1], "{layered}");
        // When all has faded, nothing is left of any edit, undone or made again.
        opened.advance(&context, 100.0).unwrap();
        while history.undo(&context, &mut opened).unwrap().is_some() {}
        while history.redo(&context, &mut opened).unwrap().is_some() {}
        opened.advance(&context, 101.0).unwrap();
        assert!(stamps(&context, &mesh, &mut opened).is_empty());
        assert_eq!(opened.bytes(), bytes, "{layered}");
    }
}

/// A dab in the middle of a face of a row.
fn at(tile: u32) -> Dab {
    let center = DVec3::new(f64::from(tile) + 0.5, 0.5, 0.0);
    let half = DVec3::new(0.3, 0.3, 1.0);
    let brush = Brush::on_surface(center, DVec3::Z, DVec3::X, half, Falloff::Smooth).unwrap();
    Dab { brush, action: Action::Sculpt { mode: SculptMode::Draw, height: 0.1 }, strength: 1.0 }
}

#[test]
fn full_budgets_lose_the_oldest_tiles_of_layers_that_fade_alone() {
    oldest_are_lost::<DisplacedObject>();
    oldest_are_lost::<TriangleObject>();
}

fn oldest_are_lost<O: Subject>() {
    let (context, mesh) = (Context::serial(), O::row());
    let whole = O::bare(&context, &mesh, LIMIT);
    let budget = whole.room(Kind::Scalar, 3);
    // Room for three tiles, or for the stamps of three.
    for (budget, stamp_budget) in [(budget, LIMIT), (LIMIT, whole.stamp_room(3))] {
        let run = || {
            let mut object = O::bare(&context, &mesh, budget);
            object.set_decay(DecayOptions { delay: 1e3, duration: 1.0 }, stamp_budget).unwrap();
            let (mut lost, mut seen) = (0, Vec::new());
            for (time, number) in [0, 4, 2, 0, 6, 7].into_iter().enumerate() {
                object.advance(&context, time as f64).unwrap();
                assert!(object.dab(&context, &at(number)).refused.is_empty());
                assert!(object.stamp(&context).unwrap().is_empty());
                lost += object.take_lost();
                seen.push(object.allocated());
            }
            (lost, seen)
        };
        let (lost, seen) = run();
        // The first was edited again, so that it is not the oldest when the fifth comes.
        assert_eq!(
            (lost, &seen[3][..], &seen[4][..], &seen[5][..]),
            (2, &[0, 2, 4][..], &[0, 2, 6][..], &[0, 6, 7][..])
        );
        assert_eq!(run(), (lost, seen));
    }
    // What does not fade is refused as ever.
    let mut object = O::bare(&context, &mesh, budget);
    for number in [0, 4, 2] {
        object.dab(&context, &at(number));
    }
    object.set_decay(DECAY, LIMIT).unwrap();
    assert_eq!(object.dab(&context, &at(6)).refused, [6]);
    assert_eq!((object.take_lost(), object.allocated().len()), (0, 3));
}

#[test]
fn tiles_of_layers_that_fade_page_before_any_is_lost() {
    paged_first::<DisplacedObject>();
    paged_first::<TriangleObject>();
}

fn paged_first<O: Subject>() {
    let (context, mesh) = (Context::serial(), O::row());
    let budget = O::bare(&context, &mesh, LIMIT).room(Kind::Scalar, 3);
    let made = |budget: u64, file: Option<PageFile>| {
        let mut object = O::bare(&context, &mesh, budget);
        object.set_decay(DECAY, LIMIT).unwrap();
        object.page_to(file.map(|file| Arc::new(file) as _)).unwrap();
        for (time, number) in [0, 4, 2, 0, 6, 7].into_iter().enumerate() {
            object.advance(&context, 0.5 * time as f64).unwrap();
            assert!(object.dab(&context, &at(number)).refused.is_empty());
            assert!(object.stamp(&context).unwrap().is_empty());
            object.commit_displacement();
        }
        object
    };
    let (mut small, mut large) = (made(budget, Some(PageFile::new(None))), made(LIMIT, None));
    assert!(small.take_lost() == 0 && small.resident()[1] >= 2);
    // What is on pages fades as all does, until nothing is left.
    for time in [2.5, 4.0, 6.0, 10.0] {
        let [a, b] = [&mut small, &mut large].map(|object| {
            object.advance(&context, time).unwrap();
            state(&context, &mesh, object)
        });
        assert!(a == b, "{time}");
        small.commit_displacement();
        assert!(small.resident()[0] <= budget, "{time}");
    }
    assert!(small.allocated().is_empty() && stamps(&context, &mesh, &mut small).is_empty());
}

#[test]
fn stamps_are_in_order_again_when_an_edit_of_decay_is_undone() {
    in_order_again::<DisplacedObject>();
    in_order_again::<TriangleObject>();
}

fn in_order_again<O: Subject>() {
    let (context, mesh) = (Context::serial(), O::mesh());
    let mut object: O = object(&context, &mesh, true);
    let lowest = object.layers()[0].id;
    object.set_layer_decay(&context, lowest, Some(DECAY), LIMIT).unwrap();
    let before = state(&context, &mesh, &mut object);
    let fading: Vec<u32> =
        object.layers().iter().map(|layer| layer.id).filter(|id| object.decay(*id).is_some()).collect();
    assert_eq!(fading.len(), 3);
    for id in fading {
        let mut history = History::new(LIMIT);
        history.begin(&context, &mut object, "stay").unwrap();
        object.set_layer_decay(&context, id, None, LIMIT).unwrap();
        assert!(history.end(&context, &mut object).unwrap().is_some_and(|changed| changed.layers));
        assert!(state(&context, &mesh, &mut object) != before);
        history.undo(&context, &mut object).unwrap();
        assert!(state(&context, &mesh, &mut object) == before, "{id}");
    }
}

#[test]
fn a_layer_that_fades_makes_room_for_itself_and_never_loses_what_is_below() {
    room_for_itself::<DisplacedObject>();
    room_for_itself::<TriangleObject>();
}

fn room_for_itself<O: Subject>() {
    let (context, mesh) = (Context::serial(), O::row());
    for (kind, opacity) in [(Kind::Scalar, 1.0), (Kind::Scalar, 0.3), (Kind::Rgba8, 0.5), (Kind::Rgba16, 0.5)] {
        let action = match kind {
            Kind::Scalar => Action::Sculpt { mode: SculptMode::Draw, height: 0.1 },
            _ => Action::Paint { mode: PaintMode::Mix, color: [0.9, 0.1, 0.2, 1.0] },
        };
        let at = |tile: u32| Dab { action, ..at(tile) };
        let bare = |budget: u64| O::made(&context, &mesh, budget, kind == Kind::Rgba16);
        let budget = bare(LIMIT).room(kind, 3);
        let made = |dabs: &[(u32, f64)]| {
            let mut object = bare(budget);
            object.dab(&context, &at(0));
            let settings = Settings { opacity, ..Settings::of(kind) };
            let (id, _) = object.add_layer(&context, kind, "tracks", settings, 16).unwrap();
            object.set_layer_decay(&context, id, Some(DecayOptions { delay: 1e3, duration: 1.0 }), LIMIT).unwrap();
            for (number, time) in dabs {
                object.advance(&context, *time).unwrap();
                assert!(object.dab(&context, &at(*number)).refused.is_empty(), "{kind:?} {number}");
                assert!(object.stamp(&context).unwrap().is_empty());
                object.settle(&context).unwrap();
            }
            (object, id)
        };
        let (mut object, id) = made(&[(2, 0.0), (4, 1.0), (6, 2.0), (4, 3.0), (7, 4.0)]);
        let (mut other, _) = made(&[(4, 1.0), (4, 3.0), (7, 4.0)]);
        assert_eq!((object.take_lost(), other.take_lost()), (2, 0), "{kind:?}");
        let [a, b] = [&mut object, &mut other].map(|object| state(&context, &mesh, object));
        assert!(a == b, "{kind:?} {opacity}");
        // Merged with what is below, it stays as that does.
        object.merge_layer(&context, id).unwrap();
        assert_eq!(object.dab(&context, &at(2)).refused, [2]);
        assert_eq!(object.take_lost(), 0);
    }
}

#[test]
fn a_layer_of_half_floats_that_fades_alone_loses_its_oldest_tiles() {
    half_floats_are_lost::<DisplacedObject>();
    half_floats_are_lost::<TriangleObject>();
}

fn half_floats_are_lost<O: Subject>() {
    let (context, mesh) = (Context::serial(), O::row());
    let action = Action::Paint { mode: PaintMode::Mix, color: [7.5, 0.1, 0.2, 1.0] };
    let budget = O::made(&context, &mesh, LIMIT, true).room(Kind::Rgba16, 3);
    let made = |tiles: &[u32]| {
        let mut object = O::made(&context, &mesh, budget, true);
        object.set_decay(DECAY, LIMIT).unwrap();
        for (time, number) in tiles.iter().enumerate() {
            object.advance(&context, time as f64 / tiles.len() as f64).unwrap();
            assert!(object.dab(&context, &Dab { action, ..at(*number) }).refused.is_empty());
            assert!(object.stamp(&context).unwrap().is_empty());
        }
        object
    };
    let mut object = made(&[0, 4, 2, 0, 6, 7]);
    assert_eq!((object.take_lost(), object.painted_tiles()), (2, made(&[0, 6, 7]).painted_tiles()));
    object.advance(&context, 8.0).unwrap();
    assert!(object.painted_tiles().is_empty() && stamps(&context, &mesh, &mut object).is_empty());
}

/// Neighbours share edges and corners, so that a face that is lost leaves none of its own, and never more than fades.
#[test]
fn faces_that_are_lost_take_their_edges_and_corners_and_nothing_that_stays() {
    let mesh = TriangleObject::mesh();
    let run = |threads: usize, layered: bool| {
        let context = Context::new(&ContextOptions { threads, memory_limit: 0 }).unwrap();
        let budget = TriangleObject::bare(&context, &mesh, LIMIT).room(Kind::Rgba8, 13);
        let mut object = TriangleObject::bare(&context, &mesh, budget);
        let stays = Dab { strength: 1.0, ..at(1) };
        let paint = Dab { action: Action::Paint { mode: PaintMode::Mix, color: [0.0, 0.0, 1.0, 1.0] }, ..at(2) };
        for dab in [stays, paint] {
            assert!(object.dab(&context, &dab).unwrap().refused.is_empty());
        }
        object.settle(&context).unwrap();
        let kept: Vec<u32> = object.displacement().field().allocated().collect();
        let painted: Vec<u32> = object.paint().unwrap().field().allocated().collect();
        let before = object.displacement().field().clone();
        if layered {
            for (kind, name) in [(Kind::Scalar, "tracks"), (Kind::Rgba8, "frost")] {
                let (id, _) = object.add_layer(&context, kind, name, Settings::of(kind), 16).unwrap();
                object.set_layer_decay(&context, id, Some(DECAY), LIMIT).unwrap();
            }
        } else {
            object.set_decay(DECAY, LIMIT).unwrap();
        }
        let (mut random, mut lost, mut history) = (Random(5), 0, History::new(LIMIT));
        for edit in 0..60 {
            object.advance(&context, 0.05 * f64::from(edit)).unwrap();
            let there = state(&context, &mesh, &mut object);
            history.begin(&context, &mut object, "dab").unwrap();
            // What stays is left alone.
            object.dab(&context, &dab_above(&mut random, 2.2)).unwrap();
            let changed = history.end(&context, &mut object).unwrap().is_some();
            object.commit(&context).unwrap();
            lost += object.take_lost();
            check_closed(object.displacement().field());
            check_closed(object.paint().unwrap().field());
            assert!(object.displacement().bytes() <= budget && object.paint().unwrap().bytes() <= budget);
            // What was lost comes back with undo.
            if changed && edit % 7 == 3 && !layered {
                history.undo(&context, &mut object).unwrap().unwrap();
                assert!(state(&context, &mesh, &mut object) == there, "{edit}");
                history.redo(&context, &mut object).unwrap().unwrap();
            }
        }
        assert!(lost > 20, "{lost}");
        let field = object.displacement().field();
        for face in &kept {
            assert!(field.face(*face).is_some() && field.face(*face) == before.face(*face), "{face}");
        }
        assert!(painted.iter().all(|face| object.paint().unwrap().field().is_allocated(*face)));
        // When all has faded, what stays is there and nothing else.
        object.advance(&context, 100.0).unwrap();
        object.settle(&context).unwrap();
        assert_eq!(object.displacement().field().allocated().collect::<Vec<_>>(), kept);
        assert!(stamps(&context, &mesh, &mut object).is_empty());
        (lost, state(&context, &mesh, &mut object))
    };
    for layered in [false, true] {
        assert!(run(1, layered) == run(3, layered));
    }
}
