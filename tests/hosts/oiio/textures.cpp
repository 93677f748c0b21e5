// OpenImageIO's texture system looks documents and Ptex files up through the plugin of OIIO_LIBRARY_PATH: what it finds
// is what the detail has there, from many threads at once, and damaged files are errors. Writes painted.relievo,
// triangles.relievo, painted.ptx and damaged.relievo to the folder it is given, for oiiotool to read afterwards.
#include "../../c/check.h"

#include <OpenImageIO/imageio.h>
#include <OpenImageIO/texture.h>

#include <atomic>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

using namespace OIIO;

namespace {

constexpr int SIDE = 32, TILES = 9, TRIANGLES = 18;

/// A place on the surface and what the detail has there.
struct Known {
    uint32_t tile;
    float uv[2];
    float displacement;
    float color[4];
};

/// Places in all tiles: centres of texels, on edges and at random.
std::vector<Known> known_places(RlvDetail detail, int tiles) {
    std::vector<Known> all;
    uint32_t random = 1;
    for (uint32_t k = 0; k < 600; ++k) {
        Known known = {};
        known.tile = k % uint32_t(tiles);
        for (float &parameter : known.uv) {
            random = random * 1664525u + 1013904223u;
            parameter = (0.5f + float((random >> 8) % SIDE)) / SIDE;
        }
        if (k % 4 == 0) {
            known.uv[0] = k % 8 == 0 ? 0.0f : 1.0f;
        }
        if (tiles != TILES && known.uv[0] + known.uv[1] > 1.0f) {
            known.uv[0] = 1.0f - known.uv[0];
            known.uv[1] = 1.0f - known.uv[1];
        }
        all.push_back(known);
    }
    RlvEvaluateArrays arrays = RLV_EVALUATE_ARRAYS_INIT;
    arrays.count = all.size();
    arrays.tiles = &all[0].tile;
    arrays.uvs = all[0].uv;
    arrays.displacements = &all[0].displacement;
    arrays.colors = all[0].color;
    arrays.tile_stride = arrays.uv_stride = arrays.displacement_stride = arrays.color_stride = sizeof(Known);
    CHECK_OK(rlv_evaluate_detail(detail, &arrays));
    return all;
}

/// Where tiles are in a sub-image, from its metadata alone.
struct Cells {
    int columns = 0, cell = 0, side = 0, gutter = 0, width = 0, height = 0;

    Cells(TextureSystem *textures, const std::string &path, int subimage, int tiles) {
        ImageSpec spec;
        CHECK(textures->get_imagespec(ustring(path), subimage, spec));
        columns = spec.get_int_attribute("relievo:columns");
        cell = spec.get_int_attribute("relievo:cell");
        side = spec.get_int_attribute("relievo:side");
        gutter = spec.get_int_attribute("relievo:gutter");
        width = spec.width;
        height = spec.height;
        CHECK(columns == (tiles == TILES ? 3 : 5) && cell == 40 && side == SIDE && gutter == 4);
        CHECK(spec.get_int_attribute("relievo:faces") == tiles && spec.get_int_attribute("relievo:tiles") == tiles);
        CHECK(spec.get_string_attribute("relievo:surface") == (tiles == TILES ? "catmull-clark" : "triangles"));
        CHECK(!spec.get_string_attribute("relievo:writer").empty());
    }

    float s(const Known &place) const {
        return (float(int(place.tile) % columns * cell + gutter) + place.uv[0] * float(side)) / float(width);
    }
    float t(const Known &place) const {
        return (float(int(place.tile) / columns * cell + gutter) + place.uv[1] * float(side)) / float(height);
    }
};

/// The largest differences of displacement and colour between the texture system and the detail.
void compare(TextureSystem *textures, const std::string &path, const std::vector<Known> &places, int tiles) {
    const Cells cells(textures, path, 0, tiles);
    TextureOpt options;
    options.mipmode = TextureOpt::MipModeNoMIP;
    options.interpmode = TextureOpt::InterpBilinear;
    options.swrap = options.twrap = TextureOpt::WrapClamp;
    float highest = 0.0f;
    for (const Known &place : places) {
        const float s = cells.s(place), t = cells.t(place);
        float color[4] = {}, displacement = 0.0f;
        // By name, as shaders do.
        options.subimagename = ustring("color");
        CHECK(textures->texture(ustring(path), options, s, t, 0, 0, 0, 0, 4, color));
        options.subimagename = ustring("displacement");
        CHECK(textures->texture(ustring(path), options, s, t, 0, 0, 0, 0, 1, &displacement));
        CHECK_NEAR(displacement, place.displacement, 3e-4);
        for (int channel = 0; channel < 4; ++channel) {
            CHECK_NEAR(color[channel], place.color[channel], 6e-3);
        }
        highest = std::max(highest, displacement);
    }
    CHECK(highest > 0.05f);
    // Filtered over a cell, the mean of what is there.
    TextureOpt wide;
    wide.subimage = 0;
    float color[4] = {};
    const float width = 4.0f / float(cells.width);
    CHECK(textures->texture(ustring(path), wide, cells.s(places[4]), cells.t(places[4]), width, 0, 0, width, 4, color));
    CHECK(color[3] > 0.9f && color[3] < 1.1f);
}

void write_damaged(const std::string &from, const std::string &to, size_t at, bool cut) {
    std::ifstream in(from, std::ios::binary);
    std::string bytes((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
    CHECK(bytes.size() > at);
    bytes[at] = char(bytes[at] ^ 0x5a);
    std::ofstream(to, std::ios::binary).write(bytes.data(), std::streamsize(cut ? at : bytes.size()));
}

} // namespace

int main(int argc, char **argv) {
    CHECK(argc == 2);
    const std::string folder = argv[1], document_path = folder + "/painted.relievo", ptex_path = folder + "/painted.ptx",
                      damaged_path = folder + "/damaged.relievo";
    RlvContext context = RLV_NULL;
    RlvSurface surface = RLV_NULL;
    RlvDetail detail = RLV_NULL;
    RlvDocument document = RLV_NULL;
    RlvDetailOptions options = RLV_DETAIL_OPTIONS_INIT;
    RlvPaintOptions paint = RLV_PAINT_OPTIONS_INIT;
    CHECK_OK(rlv_context_create(nullptr, &context));
    const RlvMesh plane = check_plane(context, 3, 3);
    CHECK_OK(rlv_surface_create(context, plane, nullptr, &surface));
    options.tile_size = paint.tile_size = SIDE;
    CHECK_OK(rlv_detail_create(surface, &options, nullptr, &detail));
    CHECK_OK(rlv_detail_add_paint(detail, &paint));
    check_stroke(context, detail, RLV_BRUSH_PAINT, 1.8, 1.6, 0.6f);
    check_stroke(context, detail, RLV_BRUSH_SCULPT, 1.8, 1.6, 0.6f);
    CHECK_OK(rlv_detail_commit(detail, nullptr));
    CHECK_OK(rlv_document_create(detail, document_path.c_str(), 0, &document));
    CHECK_OK(rlv_document_release(document));
    CHECK_OK(rlv_ptex_write(detail, RLV_CHANNEL_COLOR, ptex_path.c_str(), nullptr, nullptr));
    const std::vector<Known> places = known_places(detail, TILES);
    // The same on the triangles of the plane.
    const std::string triangles_path = folder + "/triangles.relievo";
    RlvSurface flat = RLV_NULL;
    RlvDetail faces = RLV_NULL;
    RlvSurfaceOptions kind = RLV_SURFACE_OPTIONS_INIT;
    kind.kind = RLV_SURFACE_TRIANGLES;
    CHECK_OK(rlv_surface_create(context, plane, &kind, &flat));
    CHECK_OK(rlv_detail_create(flat, &options, nullptr, &faces));
    CHECK_OK(rlv_detail_add_paint(faces, &paint));
    check_stroke(context, faces, RLV_BRUSH_PAINT, 1.8, 1.6, 0.6f);
    check_stroke(context, faces, RLV_BRUSH_SCULPT, 1.8, 1.6, 0.6f);
    CHECK_OK(rlv_detail_commit(faces, nullptr));
    CHECK_OK(rlv_document_create(faces, triangles_path.c_str(), 0, &document));
    CHECK_OK(rlv_document_release(document));
    const std::vector<Known> of_triangles = known_places(faces, TRIANGLES);
    CHECK_OK(rlv_detail_release(faces));
    CHECK_OK(rlv_surface_release(flat));

    // From eight threads at once, over a cache so small that tiles come and go; and again once it has let go of a file,
    // which it must not while others read that (OpenImageIO's issue 1334).
    TextureSystem *textures = TextureSystem::create(false);
    textures->attribute("max_memory_MB", 0.1f);
    std::vector<std::thread> threads;
    for (int round = 0; round < 2; ++round) {
        for (int k = 0; k < 8; ++k) {
            threads.emplace_back([&] {
                compare(textures, document_path, places, TILES);
                compare(textures, triangles_path, of_triangles, TRIANGLES);
            });
        }
        for (std::thread &thread : threads) {
            thread.join();
        }
        threads.clear();
        textures->invalidate(ustring(document_path));
    }

    // Faces of Ptex are sub-images.
    int count = 0;
    CHECK(textures->get_texture_info(ustring(ptex_path), 0, ustring("subimages"), TypeInt, &count) && count == TILES);
    for (const Known &place : places) {
        TextureOpt one;
        one.subimage = int(place.tile);
        one.mipmode = TextureOpt::MipModeNoMIP;
        one.interpmode = TextureOpt::InterpClosest;
        one.swrap = one.twrap = TextureOpt::WrapClamp;
        float color[4] = {};
        CHECK(textures->texture(ustring(ptex_path), one, place.uv[0], place.uv[1], 0, 0, 0, 0, 4, color));
        if (place.uv[0] > 0.0f && place.uv[0] < 1.0f) {
            // Ptex keeps bytes as sRGB encodes them.
            const float green = place.color[1], encoded =
                green <= 0.0031308f ? 12.92f * green : 1.055f * std::pow(green, 1 / 2.4f) - 0.055f;
            CHECK_NEAR(color[1], encoded, 4e-3);
        }
    }

    // Readers of one file that seek about do not disturb one another, and one reader is read from many threads.
    const auto shared = ImageInput::open(document_path);
    CHECK(shared != nullptr);
    for (int k = 0; k < 8; ++k) {
        threads.emplace_back([&, k] {
            const auto own = ImageInput::open(document_path);
            CHECK(own != nullptr && own->seek_subimage(1, k % 3) && !own->seek_subimage(1, 3) && !own->seek_subimage(2, 0));
            for (int level = 0; level < 3; ++level) {
                const ImageSpec spec = shared->spec(1, level);
                std::vector<float> pixels(spec.image_pixels()), same(spec.image_pixels());
                CHECK(shared->read_image(1, level, 0, 1, TypeFloat, pixels.data()));
                CHECK(own->read_image(1, level, 0, 1, TypeFloat, same.data()) && pixels == same);
            }
        });
    }
    for (std::thread &thread : threads) {
        thread.join();
    }

    // Damaged files are errors with a message.
    const size_t length = size_t(std::ifstream(document_path, std::ios::binary | std::ios::ate).tellg());
    for (size_t step = 1; step < 24; ++step) {
        write_damaged(document_path, damaged_path, step * length / 24, step % 2 == 0);
        CHECK(ImageInput::open(damaged_path) == nullptr);
        CHECK(!geterror().empty());
        TextureOpt one;
        float color[4];
        textures->invalidate(ustring(damaged_path));
        CHECK(!textures->texture(ustring(damaged_path), one, 0.5f, 0.5f, 0, 0, 0, 0, 4, color) || one.missingcolor);
        CHECK(!textures->geterror().empty());
    }
    TextureSystem::destroy(textures);
    CHECK_OK(rlv_detail_release(detail));
    CHECK_OK(rlv_surface_release(surface));
    CHECK_OK(rlv_mesh_release(plane));
    CHECK_OK(rlv_context_release(context));
    return 0;
}
