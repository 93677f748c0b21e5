// The C++ header: objects share and release, failures are exceptions with their parts, vectors go in and out.
#include <relievo/relievo.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <stdexcept>

#define CHECK(condition)                                                              \
    do {                                                                              \
        if (!(condition)) {                                                           \
            std::fprintf(stderr, "%s:%d: failed: %s\n", __FILE__, __LINE__, #condition); \
            std::exit(1);                                                             \
        }                                                                             \
    } while (0)

using relievo::Float3;

static bool alive(const relievo::Mesh &mesh) {
    RlvMeshInfo info = RLV_MESH_INFO_INIT;
    return rlv_mesh_info(mesh.get(), &info) == RLV_OK;
}

/// Storage in memory, which can be full.
class Memory : public relievo::Storage {
public:
    std::vector<std::uint8_t> bytes;
    bool is_full = false;

    void read(std::uint64_t place, std::uint8_t *into, std::size_t size) override {
        std::copy_n(bytes.data() + place, size, into);
    }

    void write(std::uint64_t place, const std::uint8_t *from, std::size_t size) override {
        if (is_full) {
            throw std::runtime_error("no room");
        }
        bytes.resize(std::max<std::size_t>(bytes.size(), place + size));
        std::copy_n(from, size, bytes.data() + place);
    }

    std::uint64_t length() override { return bytes.size(); }
    void cut(std::uint64_t length) override { bytes.resize(length); }
};

/// Soft tissue: a block that is built, held, pressed and advanced, and its skin.
static void tissue(const relievo::Context &context, const relievo::Mesh &solid) {
    RlvTissueMaterial gel = RLV_TISSUE_MATERIAL_INIT;
    gel.name = "gel";
    gel.young = 8000.0f;
    gel.poisson = 0.45f;
    RlvTissueVolume volume = RLV_TISSUE_VOLUME_INIT;
    volume.name = "block";
    volume.mesh = solid.get();
    RlvTissueDescription description = RLV_TISSUE_DESCRIPTION_INIT;
    std::fill(description.cell, description.cell + 3, 0.25f);
    description.materials = &gel;
    description.material_count = 1;
    description.volumes = &volume;
    description.volume_count = 1;
    const auto made = relievo::Tissue::build(context, description);
    CHECK(made.info().element_count == 64 && made.nodes().size() == 125);
    const auto building = relievo::Job::tissue(context, description);
    building.wait();
    CHECK(building.tissue().info().checksum == made.info().checksum);
    description.bend[0] = description.bend[1] = 5.0;
    CHECK(relievo::Tissue::build(context, description).info().has_cells == 0);
    const auto lower = made.set("z-"), upper = made.set("z+");
    CHECK(lower.size() == 25);
    made.hold(lower);
    const auto skin = made.bind("skin", solid);
    RlvTissueOptions still = RLV_TISSUE_OPTIONS_INIT;
    still.gravity[2] = 0.0f;
    const auto moving = made.simulate(still);
    moving.press(upper, {{0.0, 500.0f}});
    CHECK(moving.relax(1e-3f, 5000).is_at_rest == 1);
    moving.drive(upper, 1, {{0.0, {0, 0, 0}}, {0.1, {0.01f, 0, 0}}});
    moving.advance(0.01);
    const auto advancing = relievo::Job::advance(moving, 0.01);
    advancing.wait();
    advancing.result();
    CHECK(moving.info().seconds >= 0.02 && moving.energies().kinetic > 0.0);
    const auto strains = moving.principal_strains(64);
    CHECK(moving.strains(64)[0][2] < 0.0f);
    for (const auto &strain : strains) {
        CHECK(strain[0] >= strain[1] && strain[1] >= strain[2] && strain[2] < 0.0f);
    }
    CHECK(moving.contact_pressures(125) == std::vector<float>(125, 0.0f));
    const auto skin_points = moving.mesh(skin).points();
    CHECK(skin_points[4][2] < 0.999f && skin_points[0][2] == 0.0f);
    try {
        made.find_muscle("biceps");
        CHECK(false);
    } catch (const relievo::Error &error) {
        CHECK(error.result() == RLV_ERROR_INVALID);
    }
}

int main() {
    RlvContextOptions options = RLV_CONTEXT_OPTIONS_INIT;
    options.threads = 1;
    const auto context = relievo::Context::create(options);
    CHECK(context.info().threads == 1);

    const std::vector<Float3> points{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, 1, 0}, {1, 1, 0}, {2, 1, 0}};
    auto mesh = relievo::Mesh::create(context, points, {4, 4}, {0, 1, 4, 3, 1, 2, 5, 4});
    CHECK(mesh.points() == points && mesh.triangles().size() == 4 && mesh.face_sizes().size() == 2);
    CHECK(mesh.corners()[5] == 2);

    // Copies share, moves pass on, the last one releases.
    relievo::Mesh copy = mesh;
    CHECK(copy.get().id == mesh.get().id);
    relievo::Mesh moved = std::move(mesh);
    CHECK(!mesh && moved);
    copy = relievo::Mesh();
    CHECK(alive(moved));
    const relievo::Mesh dead(moved.get());
    CHECK(rlv_mesh_retain(moved.get()) == RLV_OK);

    try {
        relievo::Mesh::create(context, points, {4}, {0, 1, 4, 9});
        CHECK(false);
    } catch (const relievo::Error &error) {
        CHECK(error.result() == RLV_ERROR_INVALID);
        CHECK(error.reason() == "point 9 does not exist");
        CHECK(error.place() == "rlv_mesh_create: face 0, corner 3");
        CHECK(!error.remedy().empty() && std::string(error.what()).find(error.reason()) != std::string::npos);
    }

    RlvAttributeArrays slots = RLV_ATTRIBUTE_ARRAYS_INIT;
    const std::uint32_t materials[] = {3, 5};
    slots.domain = RLV_DOMAIN_FACE;
    slots.type = RLV_TYPE_U32;
    slots.width = 1;
    slots.name = "material";
    slots.values = materials;
    slots.value_count = 2;
    moved.add_attribute(slots);
    CHECK(moved.attribute_integers("material")[1] == 5);
    try {
        moved.attribute_floats("material");
        CHECK(false);
    } catch (const relievo::Error &) {
    }

    const auto surface = relievo::Surface::create(context, moved);
    CHECK(surface.info().tile_count == 2 && surface.face_tiles(1).first == 1 && surface.tile_info(1).face == 1);
    const auto samples = surface.evaluate({{0, {0.5f, 0.5f}}, {1, {1.0f, 0.0f}}});
    CHECK(std::abs(samples.normals[0][2] - 1.0f) < 1e-6f);
    CHECK(std::abs(samples.positions[1][0] - 2.0f) < 1e-5f);
    CHECK(surface.evaluate({}).positions.empty());

    RlvSubdivisionOptions bilinear = RLV_SUBDIVISION_OPTIONS_INIT;
    bilinear.scheme = RLV_SCHEME_BILINEAR;
    const auto subdivision = relievo::Subdivision::create(context, moved, bilinear);
    CHECK(subdivision.info().tile_count == 2 && subdivision.face_tiles(1).second == 1);
    const auto center = subdivision.evaluate({{1, {0.5f, 0.5f}}});
    CHECK(std::abs(center.positions[0][0] - 1.5f) < 1e-6f && std::abs(center.du[0][0] - 1.0f) < 1e-6f);
    CHECK(subdivision.refine(1).info().face_count == 8);
    CHECK(subdivision.evaluate({}).positions.empty());

    const auto caster = relievo::Caster::create(context, moved);
    const auto hits = caster.cast({{{1.5f, 0.5f, 3.0f}, {0, 0, -1}}, {{9, 9, 9}, {0, 0, -1}}});
    CHECK(hits[0].face == 1 && std::abs(hits[0].distance - 3.0f) < 1e-5f);
    CHECK(hits[1].face == RLV_NO_ELEMENT && std::isinf(hits[1].distance));
    CHECK((caster.occluded({{{1.5f, 0.5f, 3.0f}, {0, 0, -1}}, {{9, 9, 9}, {0, 0, -1}}}) == std::vector<std::uint8_t>{1, 0}));

    // A box over the plane, its underside 0.2 below it.
    std::vector<Float3> corners;
    for (int index = 0; index < 8; ++index) {
        corners.push_back({index & 1 ? 2.5f : -0.5f, index & 2 ? 1.5f : -0.5f, index & 4 ? 1.0f : -0.2f});
    }
    const auto box = relievo::Mesh::create(context, corners, std::vector<std::uint32_t>(6, 4),
                                           {0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 1, 3, 7, 5, 3, 2, 6, 7, 2, 0, 4, 6});
    RlvDetailOptions coarse = RLV_DETAIL_OPTIONS_INIT;
    coarse.tile_size = 16;
    const auto detail = relievo::Detail::create(surface, coarse);
    CHECK(detail.info().allocated_count == 0 && detail.tile_info(0).block_size == 648);
    const auto collider = relievo::Collider::create(context, box);
    CHECK(collider.info().triangle_count == 12 && collider.info().is_closed == 1 && relievo::Collider::create(surface).info().triangle_count > 4);
    RlvImprintSettings settings = RLV_IMPRINT_SETTINGS_INIT;
    settings.voxels = 1 << 18;
    RlvTessellateOptions even = RLV_TESSELLATE_OPTIONS_INIT;
    even.coarse = even.fine = 16;
    const auto triangles = relievo::Tessellation::create(detail, even);
    auto kept = triangles.mesh().points();
    std::vector<Float3> normals(kept.size());
    const auto report = relievo::imprint(detail, collider, settings);
    const auto changes = detail.commit();
    CHECK(triangles.update().rebuilt == 0 && triangles.info().point_count == kept.size());
    for (const auto range : triangles.changed_ranges()) {
        triangles.get_points(range, kept, normals);
    }
    CHECK(kept == detail.tessellate(even).points() && triangles.update().range_count == 0);
    CHECK(changes.tile_count == report.changed_tiles && detail.changed_tiles().size() == changes.tile_count);
    const auto dent = detail.evaluate({{0, {0.5f, 0.5f}}});
    CHECK(dent.displacements[0] < -0.19f && dent.displacements[0] > -0.3f);
    CHECK(detail.tessellate().info().point_count > surface.tessellate().info().point_count);
    const auto block = detail.read_block(0);
    detail.write_block(0, {});
    detail.commit();
    CHECK(detail.evaluate({{0, {0.5f, 0.5f}}}).displacements[0] == 0.0f);
    detail.write_block(0, block);
    detail.commit();
    CHECK(detail.evaluate({{0, {0.5f, 0.5f}}}).displacements == dent.displacements);
    // Traces and vectors are evaluated where there are any.
    const auto traced = relievo::Detail::create(surface, coarse);
    traced.add_traces();
    traced.add_vectors();
    traced.advance(1.5);
    relievo::imprint(traced, collider, settings);
    traced.commit();
    const auto track = traced.evaluate({{0, {0.5f, 0.5f}}});
    CHECK(track.traces[0][0] > 0.99f && track.traces[0][2] == 0.0f && track.vectors[0][2] == 0.0f);
    CHECK(dent.traces.empty() && traced.channel_info(RLV_CHANNEL_TRACES).allocated_count > 0);
    CHECK(traced.read_block(0, RLV_CHANNEL_VECTORS).empty() && !traced.read_block(0, RLV_CHANNEL_TRACES).empty());
    // A stroke at once, and the same drawn.
    RlvBrushOptions draw = RLV_BRUSH_OPTIONS_INIT;
    draw.action = RLV_BRUSH_SCULPT;
    draw.mode = RLV_SCULPT_DRAW;
    RlvBrushSettings small = RLV_BRUSH_SETTINGS_INIT;
    small.radius = 0.25f;
    const auto brush = relievo::Brush::create(context, draw, small);
    brush.set_curve(RLV_CURVE_SIZE, {{0.0, 0.5}, {1.0, 1.0}});
    brush.set_stamp(2, 1, 1, {0.5f, 1.0f});
    const std::vector<RlvStrokePoint> way{{{0.2, 0.5, 0.0}, 1.0, -1.0}, {{0.8, 0.5, 0.0}, 0.5, -1.0}};
    const auto once = relievo::Detail::create(surface, coarse), drawn = relievo::Detail::create(surface, coarse);
    const auto dabs = relievo::stroke(once, brush, way).dabs;
    const auto open = relievo::Stroke::begin(drawn, brush);
    CHECK(open.extend({way[0]}).dabs == 0 && open.extend({way[1]}).dabs + open.end().dabs == dabs && dabs > 3);
    once.commit();
    drawn.commit();
    CHECK(once.read_block(0) == drawn.read_block(0) && !once.read_block(0).empty());

    // Edits of a document are undone; one that throws is taken back.
    const auto document = relievo::Document::create(drawn);
    const auto before = drawn.read_block(0);
    RlvLayerOptions half = RLV_LAYER_OPTIONS_INIT;
    half.opacity = 0.5f;
    half.tile_size = 16;
    const relievo::Layers layers(drawn);
    CHECK(document.edit("a layer", [&] { layers.add("half", half); }).is_done == 1 && layers.list().size() == 2);
    CHECK(document.edit("a stroke", [&] { relievo::stroke(drawn, brush, way); }).block_count > 0);
    drawn.commit();
    CHECK(drawn.read_block(0) != before);
    try {
        document.edit("nothing", [] { throw std::runtime_error("no"); });
        CHECK(false);
    } catch (const std::runtime_error &) {
    }
    CHECK(document.info().undo_count == 2 && document.undo().is_done == 1 && document.undo().is_done == 1);
    CHECK(document.undo().is_done == 0 && layers.list().size() == 1);
    drawn.commit();
    CHECK(drawn.read_block(0) == before);

    // A document in storage of the host; what that throws fails the call.
    const auto stored = std::make_shared<Memory>();
    document.save(stored);
    const auto saved = document.save_bytes();
    CHECK(saved.size() == stored->bytes.size() && std::equal(stored->bytes.begin(), stored->bytes.end(), saved.data()));
    CHECK(document.redo().is_done == 1 && document.undo().is_done == 1 && stored->bytes.size() > saved.size());
    stored->is_full = true;
    try {
        document.redo();
        CHECK(false);
    } catch (const relievo::Error &error) {
        CHECK(error.result() == RLV_ERROR_IO);
    }
    stored->is_full = false;
    const auto kept_elsewhere = relievo::Detail::create(surface, coarse);
    CHECK(relievo::Document::open_bytes(kept_elsewhere, saved.data(), saved.size()).info().redo_count == 2);
    CHECK(relievo::Document::mesh(context, saved.data(), saved.size()).info().face_count > 0);

    // Bakes, Ptex and transfers; what a callback throws comes out.
    RlvAttributeArrays coordinates = RLV_ATTRIBUTE_ARRAYS_INIT;
    const float uvs[] = {0, 0, .5f, 0, .5f, 1, 0, 1, .5f, 0, 1, 0, 1, 1, .5f, 1};
    coordinates.domain = RLV_DOMAIN_CORNER;
    coordinates.width = 2;
    coordinates.name = "uv";
    coordinates.values = uvs;
    coordinates.value_count = 8;
    moved.add_attribute(coordinates);
    const auto mapped = relievo::Detail::create(relievo::Surface::create(context, moved), coarse);
    relievo::imprint(mapped, collider, settings);
    mapped.commit();
    RlvBakeOptions map = RLV_BAKE_OPTIONS_INIT;
    map.width = map.height = 32;
    float lowest = 0;
    CHECK(relievo::bake(mapped, map, [&](const RlvBakePicture &picture) { lowest = picture.pixels[16 * 32 + 8]; })
              .covered_pixels == 32 * 32);
    CHECK(lowest < -0.19f);
    try {
        relievo::bake(mapped, map, [](const RlvBakePicture &) { throw std::logic_error("too much"); });
        CHECK(false);
    } catch (const std::logic_error &) {
    }
    char name[64];
    std::snprintf(name, sizeof name, "wrapper-%p.exr", static_cast<const void *>(&map));
    relievo::bake(mapped, map, name, [](float, const char *) { return true; });
    CHECK(std::remove(name) == 0);
    std::snprintf(name, sizeof name, "wrapper-%p.ptx", static_cast<const void *>(&map));
    relievo::write_ptex(mapped, RLV_CHANNEL_DISPLACEMENT, name);
    const auto other = relievo::Detail::create(relievo::Surface::create(context, moved), coarse);
    CHECK(relievo::read_ptex(other, name).face_count == 2 && std::remove(name) == 0);
    std::snprintf(name, sizeof name, "wrapper-%p.relievo", static_cast<const void *>(&map));
    relievo::Document::create(other, name);
    CHECK(relievo::transfer(context, name, moved, name).layer_count == 1);
    CHECK(relievo::Document::mesh(context, name).info().face_count == 2);
    // The document as a picture, and the detail as primitives of a renderer.
    other.commit();
    const auto picture = relievo::Picture::open(context, name);
    const auto image = picture.image(0);
    CHECK(picture.info().tile_count == 2 && image.content == RLV_PICTURE_DISPLACEMENT && image.side == 16);
    const auto pixels = picture.read(0), halves = picture.read(0, 1);
    CHECK(pixels.size() == std::size_t{4} * image.width * image.height && halves.size() == pixels.size() / 4);
    const auto first_pixel = (image.gutter + image.side / 2) * (image.width + 1);
    const float *const heights = reinterpret_cast<const float *>(pixels.data());
    CHECK(std::abs(heights[first_pixel] - other.evaluate({{0, {0.53f, 0.53f}}}).displacements[0]) < 1e-2f);
    const auto meta = picture.meta();
    CHECK(meta[0].name == "writer" && !meta[0].text.empty() && meta[2].name == "faces" && meta[2].numbers[0] == 2.0);
    try {
        picture.read(0, 9);
        CHECK(false);
    } catch (const relievo::Error &error) {
        CHECK(error.place() == "read");
    }
    CHECK(std::remove(name) == 0);
    const auto procedural = relievo::Procedural::create(detail);
    const auto table = procedural.table();
    CHECK(table.primitive_count == procedural.info().primitive_count && table.primitive_count >= 2);
    float ray[20] = {0.5f, 0.5f, 3.0f, 0.0f, 0.0f, 0.0f, -1.0f, 0.0f, INFINITY};
    const std::int32_t valid = -1;
    for (std::uint32_t primitive = 0; primitive < table.primitive_count; ++primitive) {
        table.intersect(table.data, &valid, primitive, 0, 0, ray, 1);
    }
    std::uint32_t met = 0;
    std::memcpy(&met, ray + 17, 4);
    const auto shaded = procedural.evaluate({{met, {ray[15], ray[16]}}});
    CHECK(shaded.tiles[0] == 0 && std::abs(shaded.positions[0][2] - (3.0f - ray[8])) < 1e-3f && shaded.colors.empty());
    CHECK(relievo::Procedural::create_moving(procedural, detail).info().time_step_count == 2);
    CHECK(procedural.evaluate({}).tiles.empty());

    const auto hit = relievo::Caster::create(detail).cast({{{0.5f, 0.5f, 3.0f}, {0, 0, -1}}});
    CHECK(hit[0].tile == 0 && std::abs(hit[0].position[2] - dent.displacements[0]) < 1e-3f);
    const auto followed = relievo::Tessellation::create(detail);
    const auto following = relievo::Caster::create(followed);
    following.update();
    CHECK(std::abs(following.cast({{{0.5f, 0.5f, 3.0f}, {0, 0, -1}}})[0].distance - hit[0].distance) < 1e-5f);

    // A progress callback that throws cancels, and its exception comes out.
    const auto start = relievo::moved(0, 0, 0), end = relievo::moved(0.5, 0, 0);
    try {
        relievo::sweep(detail, collider, start, end, settings, RLV_IMPRINT_MOMENT_INIT,
                       [](float, const char *) -> bool { throw std::runtime_error("no patience"); });
        CHECK(false);
    } catch (const relievo::Error &) {
        CHECK(false);
    } catch (const std::runtime_error &error) {
        CHECK(std::string(error.what()) == "no patience");
    }
    int calls = 0;
    const auto swept = relievo::sweep(detail, collider, start, end, settings, RLV_IMPRINT_MOMENT_INIT,
                                      [&calls](float, const char *) { return ++calls > 0; });
    CHECK(swept.steps >= 1 && calls == static_cast<int>(swept.steps) + 1);
    try {
        const std::vector<std::array<float, 3>> none;
        relievo::sweep(detail, collider, start, end, none, none, settings);
        CHECK(false);
    } catch (const relievo::Error &error) {
        CHECK(std::string(error.what()).find("number of points") != std::string::npos);
    }
    collider.press({0.5, 0.5, 0.0}, {0, 0, 1}, 0.1);
    CHECK(collider.info().matrix[11] < 0.21);

    // Bezier patches: a flat one, and its triangles at a level for every patch.
    std::vector<Float3> grid(16);
    for (std::size_t k = 0; k < 16; ++k) {
        grid[k] = {static_cast<float>(k % 4), static_cast<float>(k / 4), 0};
    }
    const auto patch = relievo::Bezier::create(context, grid);
    CHECK(patch.info().patch_count == 1 && patch.info().high[0] == 3);
    const auto middle = patch.evaluate({{0, {0.5f, 0.5f}}});
    CHECK(std::abs(middle.positions[0][0] - 1.5f) < 1e-6f && middle.normals[0][2] == 1 && middle.du[0][0] == 3);
    CHECK(patch.evaluate({}).positions.empty());
    RlvBezierView view = RLV_BEZIER_VIEW_INIT;
    view.eye[2] = 10;
    const auto needed = patch.levels(view);
    CHECK(needed.size() == 1 && needed[0] == 1);
    RlvBezierLevels fine = RLV_BEZIER_LEVELS_INIT;
    fine.levels = needed.data();
    fine.level_count = needed.size();
    const auto tessellated = patch.tessellate(fine);
    CHECK(tessellated.positions.size() == 16 && tessellated.corners.size() == 18 && tessellated.normals[3][2] == 1);
    CHECK(patch.mesh().info().triangle_count == 2 * 31 * 31);

    // Levels of a progressive mesh in buffers, edited and settled.
    const auto built = relievo::Job::build(patch.mesh());
    CHECK(built.wait().state == RLV_JOB_DONE);
    const auto whole = built.progressive();
    bool told = false;
    relievo::Simplify less;
    less.options.triangles = 100;
    less.locked = {0};
    less.factors.assign(patch.mesh().points().size(), 2.0f);
    float deviation = -1.0f;
    const auto fewer = less.run(patch.mesh(), &deviation);
    CHECK(fewer.triangles().size() <= 100 && fewer.triangles().size() >= 99 && deviation >= 0.0f);
    const auto lessening = relievo::Job::simplify(patch.mesh(), less);
    lessening.wait();
    CHECK(lessening.mesh().points() == fewer.points() && lessening.deviation() == deviation);
    less.options.bound = 0.01f;
    less.options.triangles = 0;
    less.run(patch.mesh(), &deviation);
    CHECK(deviation >= 0.0f && deviation <= 0.01f);
    less.weights = {{"nothing", 1.0f}};
    try {
        less.run(patch.mesh());
        CHECK(false);
    } catch (const relievo::Error &error) {
        CHECK(error.reason() == "the mesh has no attribute `nothing`");
    }

    // A sticker lies on the mesh, as a job too, and follows a pin.
    RlvDecalOptions sticker = RLV_DECAL_OPTIONS_INIT;
    sticker.width = sticker.height = 10;
    const auto corner = patch.mesh().points();
    const auto place = [&](std::size_t point) {
        return std::array<double, 3>{corner[point][0], corner[point][1], corner[point][2]};
    };
    std::vector<RlvDecalPin> pins(2, RlvDecalPin{});
    const auto near_by = place(corner.size() / 3), far_off = place(corner.size() / 2);
    for (std::size_t axis = 0; axis < 3; ++axis) {
        pins[0].position[axis] = near_by[axis];
        pins[1].position[axis] = far_off[axis];
    }
    pins[0].image[0] = pins[0].image[1] = pins[1].image[1] = 4.0;
    pins[1].image[0] = 6.0;
    const auto decal = relievo::Decal::on(patch.mesh(), sticker, pins);
    CHECK(decal.quality().flip_count == 0 && decal.quality().pin_count == 2);
    CHECK(decal.mesh(0.01).info().triangle_count == decal.quality().triangle_count);
    decal.drag_pin(1, far_off);
    decal.settle();
    const auto laying = relievo::Job::decal(patch.mesh(), sticker, pins);
    laying.wait();
    CHECK(laying.decal().quality().triangle_count > 0);

    // A crowd of the mesh: a model as a call and as a job, agents near and far, and their draws.
    patch.mesh().write("wrapper_crowd.obj");
    const auto model = relievo::CrowdModel::build(context, "wrapper_crowd.obj");
    const auto counts = model.info();
    CHECK(counts.input_triangles == 2 * 31 * 31 && std::string(model.clip(0).name) == "rest");
    CHECK(model.points().size() == counts.vertex_count && model.triangles().size() == counts.triangle_count);
    CHECK(model.mesh(0.0f).info().triangle_count == counts.input_triangles);
    CHECK(model.mesh(counts.largest_error).info().triangle_count < counts.input_triangles / 4);
    model.write("wrapper_crowd.rcrowd");
    CHECK(relievo::CrowdModel::read(context, "wrapper_crowd.rcrowd").triangles() == model.triangles());
    const auto modelling = relievo::Job::crowd(context, "wrapper_crowd.obj");
    modelling.wait();
    CHECK(modelling.crowd_model().clusters().size() == model.clusters().size());
    const auto refitted = model.refit("wrapper_crowd.obj");
    CHECK(refitted.report.growth == 1.0 && refitted.report.is_rebuild_due == 0);
    CHECK(refitted.model.triangles() == model.triangles() && refitted.model.get().id != model.get().id);
    const auto refitting = relievo::Job::refit(model, "wrapper_crowd.obj");
    CHECK(refitting.take().triangles() == model.triangles() && refitting.crowd_refit_report().grown_groups == 0);
    const auto dual = model.with_blend(RLV_CROWD_BLEND_DUAL_QUATERNION);
    CHECK(dual.info().blend == RLV_CROWD_BLEND_DUAL_QUATERNION && model.info().blend == RLV_CROWD_BLEND_LINEAR);
    const auto blending = relievo::Job::with_blend(dual, RLV_CROWD_BLEND_LINEAR);
    CHECK(blending.take().info().blend == RLV_CROWD_BLEND_LINEAR);
    auto crowd = relievo::Crowd::create(context, {model});
    RlvCrowdAgent agent{};
    agent.transform[0] = agent.transform[4] = agent.transform[8] = 1.0;
    std::vector<RlvCrowdAgent> agents(3, agent);
    agents[2].transform[11] = -1000.0;
    CHECK(crowd.add(agents) == 0);
    RlvCrowdView crowd_view = RLV_CROWD_VIEW_INIT;
    crowd_view.width = crowd_view.height = 200;
    crowd_view.eye[2] = 5.0;
    const auto crowd_frame = crowd.cut(crowd_view);
    const auto crowd_draws = crowd.draws(crowd_frame);
    CHECK(crowd_frame.agent_count == 3 && crowd_draws.instances.size() == 3 && crowd_draws.matrices.size() == 1);
    CHECK(crowd_draws.draws.size() == crowd_frame.draw_count && crowd_draws.clusters[0][0] == 0);
    CHECK(model.collapses().size() == model.points().size() && crowd_draws.blends.size() == crowd_draws.draws.size());
    CHECK(model.offsets().empty() && crowd_draws.weights.empty() && crowd_draws.first_weights.size() == 3);
    auto stream = relievo::CrowdStream::open(context, {"wrapper_crowd.rcrowd"});
    CHECK(stream.add(agents) == 0 && stream.cut(crowd_view).triangles == crowd_frame.triangles);
    CHECK(stream.info().missing == 0 && stream.model(0).points() == model.points());
    for (const auto &cluster : stream.read()) {
        const auto all = model.triangles();
        const auto first = all.begin() + model.clusters()[cluster.cluster].first_triangle;
        CHECK(std::equal(first, first + cluster.triangle_count, stream.triangles(cluster).begin()));
    }
    const auto dual_rows = crowd.dual_rows(crowd_frame);
    CHECK(dual_rows.size() == 1 && dual_rows[0][0] == 1.0f && dual_rows[0][15] == 1.0f && dual_rows[0][19] == 0.0f);
    crowd_view.eye[2] = -500.0;
    crowd_view.target[2] = -1000.0;
    CHECK(crowd.cut(crowd_view).agent_count == 1 && crowd.cut(crowd_view, {{{0.0, 0.0, 1.0}, 0.01}}).agent_count == 3);
    crowd_view.eye[2] = 5.0;
    crowd_view.impostors = 1;
    const auto far_frame = crowd.cut(crowd_view);
    const auto quads = crowd.impostors(far_frame);
    CHECK(far_frame.agent_count == 2 && quads.impostors.size() == 1 && quads.impostors[0].agent == 2);
    CHECK(quads.pictures.size() == 1 && quads.pictures[0].radius > 0.0f && quads.texels.size() == 32 * 32);
    crowd.reset_weights(1);
    crowd.set(0, {agent});

    // A mesh with one boundary is checked; its boundary is no hole to be filled.
    CHECK(relievo::check(patch.mesh()).holes.count == 1);
    const auto repaired = relievo::repair(patch.mesh());
    CHECK(repaired.report.filled_holes == 0 && repaired.mesh.info().triangle_count == 2 * 31 * 31);
    const auto repairing = relievo::Job::repair(patch.mesh());
    repairing.wait();
    CHECK(repairing.mesh().points() == repaired.mesh.points() && repairing.repair_report().open_holes.count == 1);
    try {
        relievo::repair(context, "no-such-file.obj");
        CHECK(false);
    } catch (const relievo::Error &error) {
        CHECK(error.result() == RLV_ERROR_NOT_FOUND);
    }

    CHECK(relievo::Progressive::create(patch.mesh(), RLV_PROGRESSIVE_OPTIONS_INIT, [&](float, const char *) {
        return told = true;
    }).info().triangle_count == whole.info().triangle_count && told);
    std::snprintf(name, sizeof name, "wrapper-%p.rlvpm", static_cast<const void *>(&whole));
    whole.write(name);
    CHECK(relievo::Progressive::read(context, name).info().triangle_count == 2 * 31 * 31 && std::remove(name) == 0);
    const auto arrival = relievo::Arrival::create(context);
    CHECK(arrival.push(nullptr, 0).triangle_count == 0 && arrival.push(nullptr, 0).is_complete == 0);
    const auto level = relievo::Level::create(whole);
    level.take_up(whole);
    relievo::Level::Buffers buffers(whole);
    level.set_triangles(500);
    level.update(buffers);
    CHECK(buffers.last.triangle_count <= 500 && buffers.last.vertex_count == level.info().vertex_count);
    CHECK(level.edit({{{{1.5f, 1.5f, 0}, 1, RLV_FALLOFF_LINEAR}, {0, 0, 1}, {0, 0, 1}, 0, 0}},
                     {{{0, 0, 0}, 0.5f, RLV_FALLOFF_CONSTANT}}) > 0);
    level.undo();
    level.redo();
    RlvBrushOptions carving = RLV_BRUSH_OPTIONS_INIT;
    carving.action = RLV_BRUSH_SCULPT;
    carving.mode = RLV_SCULPT_DRAW;
    RlvBrushSettings wide = RLV_BRUSH_SETTINGS_INIT;
    wide.radius = 0.5f;
    const auto carved = level.sculpt(relievo::Brush::create(context, carving, wide), {{{0.5, 0.5, 0}, 1, -1}});
    CHECK(carved.dabs == 1 && carved.missed_dabs == 0 && carved.vertices > 0 && level.info().undo_count == 2);
    level.set_error(0);
    CHECK(level.set_bound(0.1f) <= 0.1f);
    RlvLevelView looking = RLV_LEVEL_VIEW_INIT;
    looking.eye[2] = 3;
    level.set_view(looking);
    level.set_triangles(SIZE_MAX);
    level.update(buffers);
    CHECK(buffers.last.triangle_count == whole.info().triangle_count);
    const auto written = buffers.last.changed_vertex_count == 0 ? 0 : level.changed_ranges(RLV_DOMAIN_POINT).front().first;
    CHECK(written == buffers.last.first_vertex && !level.changed_ranges(RLV_DOMAIN_FACE).empty());
    CHECK(level.mesh().info().high[2] > 0.5f);
    const auto moving = relievo::Level::create(whole);
    moving.add_motion({{{{1.5f, 1.5f, 0}, 9, RLV_FALLOFF_CONSTANT},
                        {{0, {0, 0, 0}, {0, 0, 1}, 0, 0}, {2, {0, 0, 1}, {0, 0, 1}, 0, 0}}}});
    const float level_before = moving.mesh().info().high[2];
    CHECK(moving.set_time(1) > 0 && std::fabs(moving.mesh().info().high[2] - level_before - 0.5f) < 1e-5f);
    moving.clear_motions();
    CHECK(moving.mesh().info().high[2] == level_before);
    level.misplaced();
    CHECK(relievo::Level::create(level.rebuild()).misplaced().empty());
    const auto journalled = relievo::Level::create(whole);
    std::snprintf(name, sizeof name, "wrapper-%p.journal", static_cast<const void *>(&whole));
    journalled.open_journal(name);
    CHECK(journalled.edit({{{{1.5f, 1.5f, 0}, 9, RLV_FALLOFF_LINEAR}, {0, 0, 1}, {0, 0, 1}, 0, 0}}) > 0);
    journalled.sync_journal();
    journalled.close_journal();
    const auto recovered = relievo::Level::create(whole);
    recovered.open_journal(name);
    CHECK(recovered.info().undo_count == 1 && recovered.mesh().info().high[2] == journalled.mesh().info().high[2]);
    recovered.close_journal();
    CHECK(std::remove(name) == 0);
    RlvProgressiveOptions furnished = RLV_PROGRESSIVE_OPTIONS_INIT;
    furnished.keeps_attributes = 1;
    const auto named = relievo::Progressive::create(moved, furnished);
    CHECK(named.info().attribute_count == 2 && std::string(named.attribute_info(0).name) == "uv");
    relievo::Level::Buffers rows(named);
    const auto finest = relievo::Level::create(named);
    finest.set_triangles(SIZE_MAX);
    finest.update(rows);
    CHECK(rows.last.wedge_count == named.info().wedge_count && rows.wedges.size() == rows.last.triangle_count);
    const auto apart = relievo::Level::create(level.settle());
    apart.set_triangles(SIZE_MAX);
    relievo::Level::Buffers others(whole);
    apart.update(others, true);
    CHECK(others.last.changed_vertex_count == others.last.vertex_count && apart.mesh().info().high[2] > 0.5f);

    // A block of a fluid in a basin, here and in the background, its surface, its mesh and rays.
    const auto fluid = relievo::Fluid::create(context);
    fluid.set_basin({0, 0, 0}, {0.2, 0.16, 0.3});
    fluid.add_box({0, 0, 0}, {0.16, 0.16, 0.16});
    bool watched = false;
    CHECK(fluid.advance(0.01, [&](float, const char *) { return watched = true; }).steps > 0 && watched);
    const auto advancing = relievo::Job::advance(fluid, 0.01);
    CHECK(advancing.wait().state == RLV_JOB_DONE && advancing.fluid_report().steps > 0);
    fluid.accelerate(std::vector<relievo::Float3>(512, {1, 0, 0}));
    CHECK(fluid.step(0.001f).seconds > 0 && fluid.info().momentum[0] > 0);
    fluid.add({{0.1f, 0.08f, 0.25f}}, {0, 0, -1});
    fluid.add({{0.05f, 0.08f, 0.25f}}, std::vector<relievo::Float3>{{0, 0, -2}}, 1.0f);
    fluid.set_channel({"heat", 1, std::vector<float>(514, 0.5f)});
    fluid.add({{0.05f, 0.12f, 0.25f}}, {0, 0, 0}, 0.0f, {{"heat", 1, {2.0f}}, {"color", 3, {1, 0, 0}}});
    fluid.add({{0.1f, 0.12f, 0.25f}}, std::vector<relievo::Float3>{{0, 0, 0}}, 0.0f, {{"heat", 1, {3.0f}}});
    CHECK(fluid.info().channel_count == 2 && fluid.channel("heat").values[514] == 2.0f);
    CHECK(fluid.channel(1).name == "color" && fluid.channel(1).values[3 * 514] == 1.0f && fluid.channel(0).values[515] == 3.0f);
    CHECK(fluid.isosurface().mesh().info().attribute_count == 4);
    CHECK(fluid.remove({514, 515}) == 2);
    const auto state = fluid.state();
    CHECK(state.numbers.size() == 514 && state.numbers.back() == 513 && state.velocities.back()[2] == -2);
    CHECK(fluid.remove({512, 513, 999}) == 2 && fluid.densities().size() == 512);
    const auto pictured = fluid.particles();
    pictured.write("wrapper_particles.rlvfluid");
    const auto read = relievo::Particles::read(context, "wrapper_particles.rlvfluid");
    CHECK(read.points() == fluid.state().points && read.numbers() == fluid.state().numbers && read.info().spacing == 0.02f);
    CHECK(read.channel("heat").values == fluid.channel("heat").values && read.channel(0).name == "velocity");
    const auto seen_of = read.keep(read.isosurface().classify());
    CHECK(seen_of.info().count <= 512 && seen_of.channel("blind").width == 1);
    const auto own = relievo::Particles::create(context, {{0, 0, 0}, {1, 0, 0}}, {{"blind", 1, {0, 1}}}, 0.02f, {7, 9});
    CHECK(own.numbers()[1] == 9 && own.isosurface(RLV_ISOSURFACE_OPTIONS_INIT).info().particle_count == 2);
    const auto second = relievo::Fluid::create(context), third = relievo::Fluid::create(context);
    second.add(own);
    CHECK(second.info().particle_count == 2 && second.info().channel_count == 0);
    fluid.save("wrapper_particles.rlvfluid");
    second.restore("wrapper_particles.rlvfluid");
    const auto as_bytes = fluid.save_bytes();
    third.restore_bytes(as_bytes.data(), as_bytes.size());
    CHECK(second.state().points == fluid.state().points && third.state().births == fluid.state().births);
    std::remove("wrapper_particles.rlvfluid");
    const auto surface_of = fluid.isosurface();
    CHECK(surface_of.info().particle_count == 512 && surface_of.classify().size() == 512);
    RlvIsosurfaceMeshOptions finer = RLV_ISOSURFACE_MESH_OPTIONS_INIT;
    finer.iterations = 2;
    const auto wet = surface_of.mesh(finer, {{"age", 1, std::vector<float>(512, 2.0f)}});
    CHECK(wet.info().attribute_count == 5 && wet.info().high[2] < 0.2f);
    const auto meshing = relievo::Job::mesh(surface_of, finer);
    CHECK(meshing.wait().state == RLV_JOB_DONE && meshing.mesh().points() == wet.points());
    const RlvIsosurfaceRay down{{0.08f, 0.08f, 1}, {0, 0, -1}, 0, 0, 0};
    const auto wet_hits = surface_of.cast({{{0.08f, 0.08f, 1}, {0, 0, -1}, 0}, {{0.08f, 0.08f, 1}, {0, 0, -1}}});
    CHECK(std::isinf(wet_hits[0].distance));
    RlvIsosurfaceHit wet_hit;
    const auto functions = surface_of.table();
    CHECK(functions.intersect(functions.data, &down, &wet_hit) == 1 && wet_hit.distance == wet_hits[1].distance);
    CHECK(wet_hit.normal[2] > 0.9f && wet_hit.position[2] > 0.1f && wet_hit.position[2] < 0.2f);
    const auto drop = relievo::Isosurface::create(context, {{0, 0, 0}}, RLV_ISOSURFACE_OPTIONS_INIT, {{1, 0, 0}}, {0});
    CHECK(drop.info().has_velocities == 1);
    try {
        relievo::Isosurface::create(context, {{0, 0, 0}}, RLV_ISOSURFACE_OPTIONS_INIT, {}, {0, 0});
        CHECK(false);
    } catch (const std::invalid_argument &) {
    }
    const auto obstacle = fluid.add_collider(patch.mesh(), relievo::moved(9, 9, 9));
    auto lifted = patch.mesh().points();
    for (auto &point : lifted) {
        point = {point[0] + 9, point[1] + 9, point[2] + 10};
    }
    fluid.move_collider(obstacle, lifted, 0.1f);
    fluid.step(0.001f);
    CHECK(obstacle == 0 && fluid.impulse(obstacle)[0] == 0.0 && fluid.impulse(RLV_FLUID_WALLS)[2] < 0);
    RlvFluidEmitterOptions tap = RLV_FLUID_EMITTER_OPTIONS_INIT;
    tap.center[2] = 5;
    tap.speed = 100;
    fluid.add_emitter(tap);
    fluid.set_forces({{RLV_FLUID_GRAVITY, 0, {0, 0, 1}, 0, {}, 0, 0}});
    fluid.set_budget(100000);
    const auto poured = fluid.advance(0.001);
    CHECK(poured.added > 0 && poured.forces[2] > 0);
    fluid.add_sink({-1, -1, 4}, {1, 1, 9});
    CHECK(fluid.step(0.0001f).removed >= poured.added);
    fluid.clear_sources();
    fluid.set_walls({{0, 0, 0}});
    fluid.move_walls({{0, 0, 1}}, {{0, 0, 1}});
    fluid.set_walls({});
    CHECK(fluid.info().wall_count == 0);

    // Jobs: results by kind, failures as exceptions.
    const auto job = relievo::Job::sweep(detail, collider, end, start);
    CHECK(job.wait().state == RLV_JOB_DONE && job.poll().fraction == 1);
    job.result();
    CHECK(job.imprint_report().steps >= 1);
    job.cancel();
    try {
        job.mesh();
        CHECK(false);
    } catch (const relievo::Error &error) {
        CHECK(error.result() == RLV_ERROR_INVALID);
    }
    // Both ways through Ptex, and a document to its own mesh.
    std::snprintf(name, sizeof name, "wrapper-%p.ptx", static_cast<const void *>(&job));
    relievo::Job::write_ptex(other, RLV_CHANNEL_DISPLACEMENT, name).wait();
    const auto taken_up = relievo::Job::read_ptex(other, name);
    CHECK(taken_up.wait().state == RLV_JOB_DONE && taken_up.ptex_report().face_count == 2 && std::remove(name) == 0);
    std::snprintf(name, sizeof name, "wrapper-%p.relievo", static_cast<const void *>(&job));
    relievo::Document::create(other, name);
    const auto moved_to = relievo::Job::transfer(context, name, moved, name);
    CHECK(moved_to.wait().state == RLV_JOB_DONE && moved_to.transfer_report().layer_count == 1 && std::remove(name) == 0);
    // Arrays that are borrowed, and what owns them; an allocator comes too late.
    {
        const auto arrays_of = std::make_shared<std::pair<std::vector<float>, std::vector<std::uint32_t>>>();
        *arrays_of = {{0, 0, 0, 1, 0, 0, 0, 1, 0}, {0, 1, 2}};
        RlvMeshArrays lent = RLV_MESH_ARRAYS_INIT;
        lent.points = arrays_of->first.data();
        lent.point_count = lent.corner_count = lent.face_size = 3;
        lent.corners = arrays_of->second.data();
        lent.face_count = 1;
        {
            const relievo::Mesh borrowed = relievo::Mesh::borrow(context, lent, arrays_of);
            CHECK(arrays_of.use_count() == 2 && borrowed.info().high[1] == 1.0f);
        }
        CHECK(arrays_of.use_count() == 1 && relievo::Mesh::borrow(context, lent).info().face_count == 1);
        try {
            relievo::set_allocator([](void *, std::size_t, std::size_t) -> void * { return nullptr; },
                                   [](void *, void *, std::size_t, std::size_t) {});
            CHECK(false);
        } catch (const relievo::Error &error) {
            CHECK(error.result() == RLV_ERROR_INVALID);
        }
    }
    // Results by their types, of jobs that wait for themselves.
    const relievo::JobOf<relievo::Mesh> reduced = relievo::Job::tessellate(detail);
    CHECK(reduced.kind() == RLV_JOB_KIND_MESH && reduced.take().get().id == reduced.mesh().get().id);
    const relievo::Surface limit = relievo::Job::surface(context, moved).take();
    CHECK(limit.info().face_count == moved.info().face_count);
    CHECK(relievo::Job::caster(detail).take() && relievo::Job::caster(context, moved).take());
    CHECK(relievo::Job::collider(detail).take() && relievo::Job::collider(limit, start).take());
    const relievo::Procedural blocks = relievo::Job::procedural(detail).take();
    CHECK(relievo::Job::procedural(blocks, detail).take().info().time_step_count == 2);
    std::snprintf(name, sizeof name, "wrapper-%p.obj", static_cast<const void *>(&job));
    relievo::Job::write_mesh(moved, name).take();
    CHECK(relievo::Job::read_mesh(context, name).take().info().face_count == moved.info().face_count);
    CHECK(std::remove(name) == 0);
    std::snprintf(name, sizeof name, "wrapper-%p.relievo", static_cast<const void *>(&job));
    relievo::Job::create_document(detail, name).take();
    relievo::Job::compact_document(context, name).take();
    CHECK(relievo::Job::open_picture(context, name).take());
    relievo::Job::save_document(relievo::Job::open_document(detail, name).take(), name).take();
    CHECK(std::remove(name) == 0);
    try {
        relievo::Job::read_mesh(context, "nowhere.obj").take();
        CHECK(false);
    } catch (const relievo::Error &error) {
        CHECK(error.result() == RLV_ERROR_NOT_FOUND);
    }
    const relievo::Job any = relievo::Job::tessellate(detail);
    CHECK(any.wait().kind == RLV_JOB_KIND_MESH);
    const auto meshed = relievo::Job::tessellate(detail);
    CHECK(meshed.wait(60).state == RLV_JOB_DONE && meshed.mesh().info().triangle_count > 0);

    // Devices.
    for (const RlvAdapterInfo &adapter : relievo::adapters()) {
        CHECK(adapter.name[0] != 0 && adapter.kind <= RLV_ADAPTER_SOFTWARE);
    }
    context.close_device();
    detail.check_device();
    try {
        relievo::Buffer::create(relievo::Tessellation::create(detail));
        CHECK(false);
    } catch (const relievo::Error &error) {
        CHECK(error.result() == RLV_ERROR_UNSUPPORTED);
    }
    try {
        relievo::DeviceLevel::create(whole);
        CHECK(false);
    } catch (const relievo::Error &error) {
        CHECK(error.result() == RLV_ERROR_UNSUPPORTED);
    }
    try {
        relievo::ColorBuffer::create(detail);
        CHECK(false);
    } catch (const relievo::Error &error) {
        CHECK(error.result() == RLV_ERROR_UNSUPPORTED);
    }

    CHECK(!context.stats().empty());
    context.reset_stats();
    CHECK(context.stats().empty());

    // Diffuse particles of two rows of fluid that meet, drawn as foam.
    std::vector<Float3> fluid_points, fluid_velocities;
    for (int at = 0; at < 512; ++at) {
        const int column = at % 16;
        fluid_points.push_back({0.02f * static_cast<float>(column), 0.02f * static_cast<float>(at / 16 % 4),
                                0.02f * static_cast<float>(at / 64)});
        fluid_velocities.push_back({column < 8 ? 4.0f : -4.0f, 0, 0});
    }
    const auto diffuse = relievo::Diffuse::create(context);
    const auto potentials = diffuse.potentials(fluid_points, fluid_velocities);
    CHECK(potentials.air[7] > 0.5f && potentials.air[0] < 0.5f && potentials.energies[0] > 0.0f);
    const auto diffused = diffuse.advance(fluid_points, fluid_velocities, 0.04f);
    const auto drops = diffuse.particles();
    CHECK(diffused.born > 0 && drops.positions.size() == diffused.born && diffuse.info().frames == 1);
    RlvFoamView foam_view = RLV_FOAM_VIEW_INIT;
    foam_view.width = foam_view.height = 4;
    foam_view.eye[1] = 1;
    relievo::Foam::create(context, foam_view).add(drops.foam());
    std::snprintf(name, sizeof name, "wrapper-%p.rlvfluid", static_cast<const void *>(&job));
    diffuse.save(name, 0.04);
    const auto continued = relievo::Diffuse::create(context);
    continued.restore(name);
    CHECK(continued.info().births == diffused.born && std::remove(name) == 0);

    // The same foam on a graphics device.
    for (const RlvAdapterInfo &adapter : relievo::adapters()) {
        RlvContextOptions options = RLV_CONTEXT_OPTIONS_INIT;
        options.threads = 1;
        options.device = RLV_DEVICE_GPU;
        options.adapter = adapter.name;
        const auto device = relievo::Context::create(options);
        const auto laid = [&](const relievo::Context &drawer) {
            const auto foam = relievo::Foam::create(drawer, foam_view);
            foam.add(drops.foam());
            foam.shade();
            return foam.composite(std::vector<float>(3 * 16, 0.25f), 3);
        };
        const auto ours = laid(device), theirs = laid(context);
        for (std::size_t at = 0; at < theirs.size(); ++at) {
            CHECK(std::abs(ours[at] - theirs[at]) <= 1.0f / 255.0f);
        }
        CHECK(device.info().device == RLV_DEVICE_GPU);
    }

    // Grids: a level set of a box and its mesh.
    const std::vector<Float3> box_points{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {0, 0, 1}, {1, 0, 1}, {0, 1, 1}, {1, 1, 1}};
    const auto solid = relievo::Mesh::create(context, box_points, {4, 4, 4, 4, 4, 4},
                                           {0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 1, 3, 7, 5, 3, 2, 6, 7, 2, 0, 4, 6});
    const auto level_set = relievo::Grid::from_mesh(solid);
    CHECK(level_set.info().grid_class == RLV_GRID_LEVEL_SET);
    CHECK(std::abs(level_set.sample({{0.5, 0.5, 1.1}})[0] - 0.1) < 1e-5);
    CHECK(level_set.change(RLV_GRID_TO_FOG).sample({{0.5, 0.5, 0.5}})[0] == 1.0);
    CHECK(level_set.combine(level_set, RLV_GRID_UNION).mesh().triangles().size() > 100);
    const auto gridding = relievo::Job::grid_from_mesh(solid);
    gridding.wait();
    CHECK(gridding.grid().info().active_voxels == level_set.info().active_voxels);

    // Shaders: a variable is marked, the text augmented, and the log of a pixel becomes an example.
    {
        RlvShaderOptions language = RLV_SHADER_OPTIONS_INIT;
        language.language = RLV_SHADER_WGSL;
        const auto plain = relievo::Shader::create(
            "@fragment fn fs(@location(0) uv: vec2<f32>) -> @location(0) vec4<f32> {\n    let a = uv;\n"
            "    return vec4<f32>(a, 0.0, 1.0);\n}\n", language);
        CHECK(plain.variables().size() == 2 && std::string(plain.variables()[1].name) == "a");
        const auto marked = plain.mark({1}, "a.x");
        CHECK(marked.layout().feature_count == 2 && std::string(marked.features()[1].expression) == "a.y");
        CHECK(marked.text(RLV_SHADER_MARKED).find("//. vector a.x; a.y; a.x") != std::string::npos);
        CHECK(marked.text().find("pel_take(a.x)") != std::string::npos);
        // One vector of the weight 1, features 1 and 0.5.
        const auto vector = marked.unpack({1, 1, 0x3f800000, 0x3f800000, 0x3f000000});
        auto examples = marked.examples();
        examples.add(RLV_SHADER_POSITIVE, vector);
        examples.add(RLV_SHADER_NEGATIVE, {1, 3.5f});
        CHECK(examples.pack(RLV_SHADER_CLASSIFY, 4, 5).size() == 13 && examples.pack()[0] == RLV_SHADER_RENDER);
        const auto degrees = examples.membership({1, 0.5f, 1, 2, 1, 3.5f});
        CHECK(degrees[0] == 1 && degrees[1] == 0.5f && degrees[2] == 0);
        try {
            examples.membership({1});
            CHECK(false);
        } catch (const std::invalid_argument &) {
        }
    }
    tissue(context, solid);

    // What there is, who works, failures in numbers, and a job that says when it ends.
    CHECK(relievo::capability().version == rlv_version() && relievo::formats().size() > 8);
    CHECK(relievo::wait(solid).is_busy == 0 && std::string(relievo::wait(context, 0.0).noun) == "context");
    try {
        relievo::Mesh::create(context, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {3}, {0, 1, 9});
        CHECK(false);
    } catch (const relievo::Error &error) {
        CHECK(error.element_kind() == RLV_ELEMENT_CORNER && error.element() == 2 && error.code() != 0);
    }
    int ended = 0;
    gridding.notify([](void *user) { ++*static_cast<int *>(user); }, &ended);
    CHECK(ended == 1);
    long long bytes = 0;
    context.set_memory_monitor(
        [](void *user, std::int64_t taken) {
            *static_cast<long long *>(user) += taken;
            return std::uint32_t(RLV_PROGRESS_CONTINUE);
        },
        &bytes);
    CHECK(solid.split(0.5).triangles().size() > 12);
    CHECK(bytes == 0);
    context.set_memory_monitor(nullptr, nullptr);
    return 0;
}
