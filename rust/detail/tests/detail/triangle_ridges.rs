//! What changes on an edge of a triangle mesh reaches no further than a segment into its faces, whatever becomes of them:
//! faces along an edge that is not blank have blocks.

use std::collections::BTreeSet;

use glam::{DAffine3, DMat3, DVec2, DVec3, Vec4};
use half::f16;
use relievo_core::{Context, ContextOptions, Mesh};
use relievo_detail::{
    Action, BlockState, Brush, Collider, Dab, Falloff, History, ImprintSettings, Imprinter, LayeredObject, Moment,
    PaintMode, Recorded, SculptMode, TriangleObject,
};
use relievo_document::{Blend, Document, Kind, Settings};
use relievo_surface::{TriangleSurface, TriangleTopology};
use relievo_testing::Random;
use relievo_tiles::triangle::{Node, Pattern, Slot, TriangleBlock, TriangleChannel, TriangleField, TriangleOptions};
use relievo_tiles::{Blocks, Texel};

use crate::shapes::triangle_plane;

const LIMIT: u64 = 1 << 30;

fn object(context: &Context, mesh: &Mesh, budget: u64) -> TriangleObject {
    let surface = TriangleSurface::new(context, mesh).unwrap();
    let topology = surface.topology().clone();
    let options = TriangleOptions { segments: 16, budget };
    let displacement = TriangleChannel::displacement(topology.clone(), &options).unwrap();
    let mut object = TriangleObject::new(context, surface, displacement, DAffine3::IDENTITY).unwrap();
    object.set_paint(TriangleChannel::of_color(topology, Vec4::ONE, &options).unwrap()).unwrap();
    object
}

fn dab_at((center, radius): (DVec3, f64), action: Action) -> Dab {
    let brush = Brush::new(center, DMat3::IDENTITY, DVec3::new(radius, radius, 3.0), Falloff::Constant).unwrap();
    Dab { brush, action, strength: 1.0 }
}

/// Somewhere, with a radius that may be smaller than the distance between values.
fn spot(random: &mut Random, n: u32) -> (DVec3, f64) {
    let mut place = || f64::from(random.unit()) * f64::from(n);
    let center = DVec3::new(place(), place(), 0.0);
    (center, 0.02 + 0.4 * f64::from(random.unit()))
}

fn dab(random: &mut Random, n: u32, action: Action) -> Dab {
    dab_at(spot(random, n), action)
}

fn draw(height: f32) -> Action {
    Action::Sculpt { mode: SculptMode::Draw, height }
}

fn erase() -> Action {
    Action::Sculpt { mode: SculptMode::Erase, height: 0.0 }
}

fn any_action(random: &mut Random) -> Action {
    let color = [random.unit(), random.unit(), random.unit(), 1.0];
    match random.below(7) {
        0 | 1 => draw(0.1),
        2 => draw(-0.2),
        3 => Action::Sculpt { mode: SculptMode::Smooth, height: 0.0 },
        4 => erase(),
        5 => Action::Paint { mode: PaintMode::Mix, color },
        _ => Action::Paint { mode: PaintMode::Erase, color },
    }
}

/// Presses a box into the plane somewhere, at some angle.
fn press(context: &Context, random: &mut Random, object: &mut TriangleObject, n: u32, settings: &ImprintSettings) {
    let points = (0..8).map(|k: u32| [k & 1, k >> 1 & 1, k >> 2].map(|bit| bit as f32 - 0.5)).collect();
    let faces = vec![0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5];
    let mut place = || f64::from(random.unit()) * f64::from(n);
    let middle = DVec3::new(place(), place(), 0.4);
    let turn = f64::from(random.unit());
    let size = DVec3::new(0.3 + f64::from(random.unit()), 0.3 + f64::from(random.unit()), 1.0);
    let transform = DAffine3::from_translation(middle) * DAffine3::from_rotation_z(turn) * DAffine3::from_scale(size);
    let collider = Collider::of_mesh(context, &Mesh::new(points, vec![4; 6], faces), transform).unwrap();
    Imprinter::new().imprint(context, object, &collider, settings, Moment::default()).unwrap();
}

/// Faces have edges, edges faces, and vertices and edges that are not blank have faces with blocks all around.
pub(crate) fn check_closed<T: Texel>(field: &TriangleField<T>) {
    let topology = field.topology();
    for face in field.allocated() {
        assert!(topology.edges_of(face).iter().all(|edge| field.edge_pattern(*edge) >= field.face_pattern(face)));
    }
    for edge in field.allocated_edges() {
        let is_blank = field.edge(edge).unwrap().iter().all(|value| value.same(field.blank()));
        let mut along = topology.faces_along(edge).map(|(face, _)| field.is_allocated(face));
        assert!(if is_blank { along.any(|there| there) } else { along.all(|there| there) }, "edge {edge}");
    }
    for vertex in (0..topology.vertex_count() as u32).filter(|vertex| !field.vertex(*vertex).same(field.blank())) {
        assert!(topology.faces_around(vertex).all(|(face, _)| field.is_allocated(face)), "vertex {vertex}");
    }
}

/// The places of all values that are not blank.
fn changed(object: &TriangleObject) -> Vec<DVec2> {
    let field = object.displacement().field();
    let displaced = object.displaced().unwrap();
    let mut places = Vec::new();
    for face in 0..field.topology().face_count() as u32 {
        for pattern in [4, 8, 16].map(|segments| Pattern::new(segments).unwrap()) {
            let nodes: BTreeSet<Node> = pattern.triangles().flatten().collect();
            let is_value = |node: &Node| match pattern.slot(*node) {
                Slot::Inside(_) => field.face_pattern(face) >= Some(pattern),
                Slot::Side(side, _) => field.edge_pattern(field.topology().side(face, side).edge) >= Some(pattern),
                Slot::Corner(_) => true,
            };
            for node in nodes.into_iter().filter(is_value) {
                let (foot, height) = displaced.at(face, pattern, node);
                if height != 0.0 {
                    places.push(foot.point.truncate().as_dvec2());
                }
            }
        }
    }
    places
}

/// Where a triangle that is shown is moved as far as somewhere that is more than a segment of `segments` a side from any
/// value that changed.
fn ridge(object: &TriangleObject, segments: u32) -> Option<(u32, [f32; 3])> {
    let changed = changed(object);
    // Neighbours are no further apart than four thirds of a segment of the longest side.
    let most = 4.0 / 3.0 * 2f64.sqrt() / f64::from(segments) * 1.001;
    let is_near = |[x, y, _]: [f32; 3]| {
        let place = DVec2::new(f64::from(x), f64::from(y));
        changed.iter().any(|other| other.distance(place) <= most)
    };
    let count = object.surface().topology().face_count() as u32;
    (0..count).find_map(|face| {
        let (piece, _) = object.piece(face).unwrap();
        let corners = |triangle: &[u32; 3]| triangle.map(|at| piece.points[at as usize]);
        let moved = piece.triangles.iter().map(corners).filter(|corners| corners.iter().any(|[.., z]| *z != 0.0));
        moved.flatten().find(|point| !is_near(*point)).map(|point| (face, point))
    })
}

/// Faces that have a block for the sake of their edges alone.
fn beside(field: &TriangleField) -> usize {
    let topology = field.topology();
    let blank = |values: Option<&[f16]>| values.is_none_or(|values| values.iter().all(|value| value.to_f32() == 0.0));
    let is_beside = |face: &u32| {
        blank(field.face(*face))
            && topology.face(*face).iter().all(|vertex| field.vertex(*vertex).to_f32() == 0.0)
            && topology.edges_of(*face).iter().any(|edge| !blank(field.edge(*edge)))
    };
    field.allocated().filter(is_beside).count()
}

#[test]
fn what_is_pressed_along_an_edge_reaches_no_further_than_a_segment() {
    let (context, n) = (Context::serial(), 5);
    let mesh = triangle_plane(n);
    let mut random = Random(7);
    let plain = ImprintSettings { voxels: 1 << 16, ..Default::default() };
    let smooth = ImprintSettings { smoothing: 0.5, smoothing_passes: 2, ..plain };
    let rim = ImprintSettings { rim: 0.5, rim_width: 0.2, ..plain };
    let mut met = 0;
    for (settings, what) in [(plain, "plain"), (smooth, "smooth"), (rim, "rim")] {
        for pose in 0..40 {
            let mut object = object(&context, &mesh, LIMIT);
            press(&context, &mut random, &mut object, n, &settings);
            assert_eq!(ridge(&object, 16), None, "{what} {pose}");
            check_closed(object.displacement().field());
            met += beside(object.displacement().field());
        }
    }
    assert!(met > 3, "{met}");
}

#[test]
fn dabs_at_all_levels_reach_no_further_than_a_segment() {
    let (context, n) = (Context::serial(), 4);
    let mesh = triangle_plane(n);
    let mut random = Random(11);
    let mut met = 0;
    for series in 0..60 {
        let mut object = object(&context, &mesh, LIMIT);
        let coarsest = random.below(3) as u32;
        for _ in 0..4 {
            object.set_level(random.below(coarsest as usize + 1) as u32).unwrap();
            let dab = dab(&mut random, n, draw(0.1));
            object.dab(&context, &dab).unwrap();
            assert_eq!(ridge(&object, 16 >> coarsest), None, "{series}");
            check_closed(object.displacement().field());
        }
        met += beside(object.displacement().field());
    }
    assert!(met > 10, "{met}");
}

#[test]
fn where_the_budget_refuses_a_face_its_edges_and_corners_stay() {
    let (context, n) = (Context::serial(), 4);
    let mesh = triangle_plane(n);
    let mut refused = 0;
    for seed in 0..30 {
        let mut random = Random(seed);
        let bytes = mesh.points.len() as u64 * 4;
        let mut object = object(&context, &mesh, bytes + 4 * 300 * (1 + seed % 9));
        for edit in 0..20 {
            object.set_level(random.below(3) as u32).unwrap();
            if random.below(6) == 0 {
                let settings = ImprintSettings { voxels: 1 << 14, smoothing: 0.3, ..Default::default() };
                press(&context, &mut random, &mut object, n, &settings);
            } else {
                let action = any_action(&mut random);
                let dab = dab(&mut random, n, action);
                refused += object.dab(&context, &dab).unwrap().refused.len();
            }
            check_closed(object.displacement().field());
            check_closed(object.paint().unwrap().field());
            // Colours may divide it further than values of the coarsest level do.
            assert_eq!(ridge(&object, 3), None, "{seed} {edit}");
            assert!(object.displacement().bytes() <= object.displacement().budget());
        }
    }
    assert!(refused > 100, "{refused}");
}

#[test]
fn blocks_that_faces_have_for_their_edges_go_with_what_is_on_these() {
    let (context, n) = (Context::serial(), 4);
    let mesh = triangle_plane(n);
    for seed in 0..20 {
        let mut random = Random(seed);
        let mut object = object(&context, &mesh, LIMIT);
        let [bare, unpainted] = [object.displacement().bytes(), object.paint().unwrap().bytes()];
        let mut spots = Vec::new();
        for _ in 0..12 {
            let (place, action) = (spot(&mut random, n), any_action(&mut random));
            spots.push(place);
            object.dab(&context, &dab_at(place, action)).unwrap();
        }
        // Each where it was, in another order.
        for spot in spots.into_iter().rev() {
            for action in [erase(), Action::Paint { mode: PaintMode::Erase, color: [0.0; 4] }] {
                object.dab(&context, &dab_at(spot, action)).unwrap();
            }
            check_closed(object.displacement().field());
            check_closed(object.paint().unwrap().field());
        }
        assert_eq!([object.displacement().bytes(), object.paint().unwrap().bytes()], [bare, unpainted], "{seed}");
    }
}

/// The heights and colours, to the bit.
fn seen(object: &TriangleObject) -> Vec<Vec<u8>> {
    let (heights, paint) = (object.displacement(), object.paint().unwrap());
    let blocks = heights.blocks().into_iter().map(|block| heights.read(block).unwrap().unwrap());
    blocks.chain(paint.blocks().into_iter().map(|block| paint.read(block).unwrap().unwrap())).collect()
}

#[test]
fn histories_layers_and_documents_have_the_blocks_too() {
    let n = 4;
    let mesh = triangle_plane(n);
    let run = |threads: usize, layered: bool| {
        let context = Context::new(&ContextOptions { threads, memory_limit: 0 }).unwrap();
        let mut random = Random(23);
        let mut object = object(&context, &mesh, 200 * 4 * 300);
        if layered {
            let settings = Settings { opacity: 0.5, blend: Blend::Add, visible: true };
            object.add_layer(&context, Kind::Scalar, "half", settings, 16).unwrap();
            let settings = Settings { opacity: 0.7, blend: Blend::Normal, visible: true };
            object.add_layer(&context, Kind::Rgba8, "glaze", settings, 8).unwrap();
        }
        let (mut history, mut states) = (History::new(LIMIT), vec![seen(&object)]);
        for edit in 0..40 {
            let layers = object.layers();
            if layered && random.below(5) == 0 {
                let layer = layers[random.below(layers.len())].id;
                object.set_active_layer(&context, layer).unwrap();
            }
            history.begin(&context, &mut object, "edit").unwrap();
            object.set_level(random.below(3) as u32).unwrap();
            let action = any_action(&mut random);
            object.dab(&context, &dab(&mut random, n, action)).unwrap();
            object.settle(&context).unwrap();
            let changed = history.end(&context, &mut object).unwrap().is_some();
            check_closed(object.displacement().field());
            check_closed(object.paint().unwrap().field());
            for state in object.layer_states() {
                check_layer(object.surface().topology(), &*state.blocks, &format!("edit {edit} of {}", state.name));
            }
            if changed {
                states.push(seen(&object));
            }
        }
        assert!(states.len() > 15, "{}", states.len());
        for state in states.iter().rev().skip(1) {
            history.undo(&context, &mut object).unwrap().unwrap();
            assert!(seen(&object) == *state);
        }
        for state in &states[1..] {
            history.redo(&context, &mut object).unwrap().unwrap();
            assert!(seen(&object) == *state);
        }
        let mut document = Document::of_triangles(&mesh, "x").unwrap();
        object.store(&context, &mut document).unwrap();
        let mut again = self::object(&context, &mesh, LIMIT);
        again.take_up(&context, &document, LIMIT).unwrap();
        assert!(seen(&again) == seen(&object));
        let mut copy = Document::of_triangles(&mesh, "x").unwrap();
        again.store(&context, &mut copy).unwrap();
        let bytes = document.to_bytes().unwrap();
        assert!(copy.to_bytes().unwrap() == bytes);
        bytes
    };
    for layered in [false, true] {
        assert!(run(1, layered) == run(3, layered));
    }
}

/// Fails unless faces along edges that are not blank are there in a layer.
fn check_layer(topology: &TriangleTopology, blocks: &dyn Blocks, what: &str) {
    let blank = blocks.blank();
    for number in blocks.numbers() {
        let Some(TriangleBlock::Edge(edge)) = TriangleBlock::of(topology, number) else { continue };
        let values = blocks.bytes(number).unwrap();
        if values.chunks_exact(blank.len()).any(|value| value != blank) {
            let there = |face: u32| blocks.bytes(TriangleBlock::Face(face).number(topology)).is_some();
            assert!(topology.faces_along(edge).all(|(face, _)| there(face)), "{what}: edge {edge}");
        }
    }
}

/// What an earlier build left of the heights of an object, which gave an edge one face with a block: the document, and
/// the faces that it lacks.
fn earlier(context: &Context, mesh: &Mesh, object: &TriangleObject) -> (Document, Vec<u32>) {
    let field = object.displacement().field();
    let topology = field.topology();
    let zero = |values: &[f16]| values.iter().all(|value| value.to_f32() == 0.0);
    let mut gone: Vec<u32> = Vec::new();
    for face in field.allocated() {
        let blank = zero(field.face(face).unwrap())
            && topology.face(face).iter().all(|vertex| field.vertex(*vertex).to_f32() == 0.0);
        let held = |edge: &u32| {
            let mut along = topology.faces_along(*edge).map(|(face, _)| face);
            zero(field.edge(*edge).unwrap())
                || along.any(|other| other != face && field.is_allocated(other) && !gone.contains(&other))
        };
        if blank && topology.edges_of(face).iter().all(held) {
            gone.push(face);
        }
    }
    let there = |number: &u32| match TriangleBlock::of(topology, *number).unwrap() {
        TriangleBlock::Face(face) => !gone.contains(&face),
        TriangleBlock::Edge(edge) => {
            topology.faces_along(edge).any(|(face, _)| field.is_allocated(face) && !gone.contains(&face))
        }
        TriangleBlock::Vertices(_) => true,
    };
    let numbers: Vec<u32> = field.blocks().into_iter().filter(there).collect();
    let mut document = Document::of_triangles(mesh, "x").unwrap();
    let read = |number: u32| Ok(field.bytes(number).unwrap().to_vec());
    let head = ("displacement", Kind::Scalar, Blocks::blank(field));
    document.pack(context, head, field.face_sizes(), &numbers, read).unwrap();
    (document, gone)
}

#[test]
fn documents_of_earlier_builds_get_the_blocks_that_they_lack() {
    let (context, n) = (Context::serial(), 5);
    let mesh = triangle_plane(n);
    let (mut random, mut met) = (Random(5), 0);
    let settings = ImprintSettings { voxels: 1 << 16, ..Default::default() };
    for pose in 0..60 {
        let mut object = object(&context, &mesh, LIMIT);
        press(&context, &mut random, &mut object, n, &settings);
        let (document, gone) = earlier(&context, &mesh, &object);
        met += usize::from(!gone.is_empty());
        let mut again = self::object(&context, &mesh, LIMIT);
        again.take_up(&context, &document, LIMIT).unwrap();
        again.renew(&context).unwrap();
        assert!(seen(&again) == seen(&object), "{pose}");
        // In a budget of no more than the document has, these faces stay without.
        let mut narrow = self::object(&context, &mesh, LIMIT);
        let (vertices, bare) = (narrow.displacement().bytes(), document.layers()[0].blocks());
        let topology = object.surface().topology().clone();
        let values = |tile: u32| match TriangleBlock::of(&topology, tile) {
            Some(TriangleBlock::Face(_)) => 169,
            Some(TriangleBlock::Edge(_)) => 15,
            _ => 0,
        };
        let budget = vertices + 2 * bare.iter().map(|block| values(block.tile())).sum::<u64>();
        narrow.take_up(&context, &document, budget).unwrap();
        assert!(narrow.displacement().bytes() <= budget);
        assert!(!gone.iter().any(|face| narrow.displacement().field().is_allocated(*face)));
        assert_eq!([ridge(&again, 16).is_some(), ridge(&narrow, 16).is_some()], [false, !gone.is_empty()]);
        // Edits of that build are undone and made again: blocks go and come by number.
        let heights = again.layers()[0].id;
        let state = |bytes: &dyn Fn(u32) -> Option<Vec<u8>>| -> Vec<BlockState> {
            let block = |block: &relievo_document::Block| BlockState {
                layer: heights,
                block: block.tile(),
                bytes: bytes(block.tile()),
            };
            bare.iter().map(block).collect()
        };
        let before = seen(&again);
        let there = |tile: u32| object.displacement().read(tile).unwrap();
        again.restore(&context, None, state(&|_| None)).unwrap();
        assert_eq!(again.displacement().bytes(), vertices);
        again.restore(&context, None, state(&there)).unwrap();
        assert!(seen(&again) == before);
    }
    assert!(met > 3, "{met}");
}
