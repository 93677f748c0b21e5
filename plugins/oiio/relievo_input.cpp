// OpenImageIO reads documents and Ptex files: every image of a picture (relievo/picture.h) is a sub-image, its levels are
// mip levels, and where tiles are stands in metadata that begins with "relievo:".
//
// An open file never changes and the library may be called from any thread, so that pixels are read without a lock; only
// what seek_subimage chose is kept per reader, as OpenImageIO expects.
#include <relievo/relievo.h>

#include <OpenImageIO/imageio.h>

#include <cstring>
#include <mutex>

OIIO_PLUGIN_NAMESPACE_BEGIN

namespace {

/// Bytes that one file may come to in memory.
constexpr uint64_t MEMORY_LIMIT = uint64_t(8) << 30;

/// Pixels along a tile of OpenImageIO, of which its cache keeps some.
constexpr int TILE = 64;

/// The context of all readers, which makes no threads: those of the host read. It lives as long as the process, since
/// readers may be closed by destructors of the host's static objects.
RlvContext shared_context() {
    static const RlvContext context = [] {
        RlvContextOptions options = RLV_CONTEXT_OPTIONS_INIT;
        options.threads = 1;
        options.memory_limit = MEMORY_LIMIT;
        RlvContext made = RLV_NULL;
        return rlv_context_create(&options, &made) == RLV_OK ? made : RlvContext RLV_NULL;
    }();
    return context;
}

TypeDesc type_of(uint32_t type) {
    switch (type) {
    case RLV_PICTURE_U8: return TypeDesc::UINT8;
    case RLV_PICTURE_U16: return TypeDesc::UINT16;
    case RLV_PICTURE_F16: return TypeDesc::HALF;
    case RLV_PICTURE_I32: return TypeDesc::INT;
    case RLV_PICTURE_F64: return TypeDesc::DOUBLE;
    default: return TypeDesc::FLOAT;
    }
}

const char *blend_name(uint32_t blend) {
    static const char *const names[] = {"normal", "add", "subtract", "multiply", "screen", "overlay", "max", "min"};
    return blend < sizeof names / sizeof *names ? names[blend] : "";
}

class RelievoInput final : public ImageInput {
public:
    ~RelievoInput() override { close(); }

    const char *format_name() const override { return "relievo"; }

    int supports(string_view feature) const override {
        return feature == "multiimage" || feature == "mipmap" || feature == "arbitrary_metadata";
    }

    bool valid_file(const std::string &filename) const override {
        char magic[6] = {};
        FILE *file = std::fopen(filename.c_str(), "rb");
        if (!file) {
            return false;
        }
        const bool whole = std::fread(magic, 1, sizeof magic, file) == sizeof magic;
        std::fclose(file);
        return whole && (std::memcmp(magic, "RLVDOC", 6) == 0 || std::memcmp(magic, "Ptex", 4) == 0);
    }

    bool open(const std::string &name, ImageSpec &spec) override {
        close();
        RlvPictureInfo info = RLV_PICTURE_INFO_INIT;
        if (!done(rlv_picture_open(shared_context(), name.c_str(), &picture_)) || !done(rlv_picture_info(picture_, &info))) {
            close();
            return false;
        }
        info_ = info;
        if (!seek_subimage(0, 0)) {
            close();
            return false;
        }
        spec = m_spec;
        return true;
    }

    bool close() override {
        if (picture_.id) {
            rlv_picture_release(picture_);
        }
        picture_ = RLV_NULL;
        subimage_ = miplevel_ = -1;
        m_spec = ImageSpec();
        return true;
    }

    int current_subimage() const override { return std::max(subimage_, 0); }
    int current_miplevel() const override { return std::max(miplevel_, 0); }

    bool seek_subimage(int subimage, int miplevel) override {
        const std::lock_guard<ImageInput> guard(*this);
        if (subimage == subimage_ && miplevel == miplevel_) {
            return true;
        }
        ImageSpec spec;
        if (!describe(subimage, miplevel, spec, true)) {
            return false;
        }
        m_spec = spec;
        subimage_ = subimage;
        miplevel_ = miplevel;
        return true;
    }

    ImageSpec spec(int subimage, int miplevel) override {
        ImageSpec spec;
        return describe(subimage, miplevel, spec, true) ? spec : ImageSpec();
    }

    ImageSpec spec_dimensions(int subimage, int miplevel) override {
        ImageSpec spec;
        return describe(subimage, miplevel, spec, false) ? spec : ImageSpec();
    }

    bool read_native_scanline(int subimage, int miplevel, int y, int z, void *data) override {
        return read_native_scanlines(subimage, miplevel, y, y + 1, z, data);
    }

    bool read_native_scanlines(int subimage, int miplevel, int ybegin, int yend, int, void *data) override {
        ImageSpec spec;
        return describe(subimage, miplevel, spec, false) &&
               read(subimage, miplevel, 0, ybegin, spec.width, std::min(yend, spec.height) - ybegin, data, 0);
    }

    bool read_native_tile(int subimage, int miplevel, int x, int y, int, void *data) override {
        ImageSpec spec;
        if (!describe(subimage, miplevel, spec, false)) {
            return false;
        }
        // Tiles are whole, also where the image ends.
        std::memset(data, 0, spec.tile_bytes());
        return read(subimage, miplevel, x, y, std::min(spec.tile_width, spec.width - x),
                    std::min(spec.tile_height, spec.height - y), data, spec.tile_width * spec.pixel_bytes());
    }

private:
    RlvPicture picture_ = RLV_NULL;
    RlvPictureInfo info_ = RLV_PICTURE_INFO_INIT;
    int subimage_ = -1;
    int miplevel_ = -1;

    /// Whether a call succeeded; if not, its message becomes the reader's error.
    bool done(RlvResult result) const {
        if (result != RLV_OK) {
            errorfmt("{}", rlv_error_last());
        }
        return result == RLV_OK;
    }

    bool read(int subimage, int miplevel, int x, int y, int width, int height, void *data, size_t stride) const {
        if (x < 0 || y < 0 || width < 0 || height < 0) {
            errorfmt("({}, {}) is outside the image", x, y);
            return false;
        }
        return done(rlv_picture_read(picture_, uint32_t(subimage), uint32_t(miplevel), uint32_t(x), uint32_t(y),
                                     uint32_t(width), uint32_t(height), data, stride));
    }

    /// What a level of a sub-image is. False, without an error, if there is none: that is how hosts count them.
    bool describe(int subimage, int miplevel, ImageSpec &spec, bool wants_metadata) const {
        RlvPictureImage image = RLV_PICTURE_IMAGE_INIT;
        if (!picture_.id || subimage < 0 || uint32_t(subimage) >= info_.image_count || miplevel < 0 ||
            !done(rlv_picture_image(picture_, uint32_t(subimage), &image)) || uint32_t(miplevel) >= image.level_count) {
            return false;
        }
        const int width = int(image.width >> miplevel), height = int(image.height >> miplevel);
        spec = ImageSpec(width, height, int(image.channels), type_of(image.type));
        // Texels of a face of Ptex are unpacked together, and so are one tile.
        spec.tile_width = info_.format == RLV_PICTURE_PTEX ? width : TILE;
        spec.tile_height = info_.format == RLV_PICTURE_PTEX ? height : TILE;
        spec.tile_depth = 1;
        spec.alpha_channel = image.alpha == RLV_PICTURE_NONE ? -1 : int(image.alpha);
        switch (image.content) {
        case RLV_PICTURE_DISPLACEMENT: spec.channelnames = {"displacement"}; break;
        case RLV_PICTURE_VECTORS: spec.channelnames = {"along", "across", "up"}; break;
        case RLV_PICTURE_TRACES: spec.channelnames = {"contact", "depth", "time"}; break;
        default: break;
        }
        if (wants_metadata) {
            attach(spec, image, subimage);
        }
        return true;
    }

    void attach(ImageSpec &spec, const RlvPictureImage &image, int subimage) const {
        static const char *const kinds[] = {"color", "displacement", "vectors", "traces"};
        const bool is_document = info_.format == RLV_PICTURE_DOCUMENT;
        const char *const kind = kinds[image.content < 4 ? image.content : 0];
        // The first of a kind is what is seen of it; shaders find it by the same name in every document.
        RlvPictureImage before = RLV_PICTURE_IMAGE_INIT;
        const bool is_first = subimage == 0 || !done(rlv_picture_image(picture_, uint32_t(subimage) - 1, &before)) ||
                              before.content != image.content;
        spec.attribute("oiio:subimagename", is_document && is_first ? kind : image.name);
        spec.attribute("oiio:subimages", int(info_.image_count));
        if (is_document) {
            spec.attribute("relievo:kind", kind);
            spec.attribute("relievo:name", image.name);
            spec.attribute("relievo:columns", int(image.columns));
            spec.attribute("relievo:cell", int(image.cell));
            spec.attribute("relievo:side", int(image.side));
            spec.attribute("relievo:gutter", int(image.gutter));
            spec.attribute("relievo:layer", int(image.is_layer));
            if (image.is_layer) {
                spec.attribute("relievo:blend", blend_name(image.blend));
                spec.attribute("relievo:visible", int(image.is_visible));
                spec.attribute("relievo:opacity", image.opacity);
            }
            spec.attribute("wrapmodes", "clamp,clamp");
            if (image.content == RLV_PICTURE_COLOR) {
                spec.attribute("oiio:ColorSpace", "Linear");
            }
        }
        // Of faces of Ptex the first has it, since there may be a million of them.
        if (info_.format == RLV_PICTURE_PTEX && image.face != 0) {
            return;
        }
        for (uint32_t index = 0; index < info_.meta_count; ++index) {
            RlvPictureMeta meta = RLV_PICTURE_META_INIT;
            if (!done(rlv_picture_meta(picture_, index, &meta)) || meta.count > 4096) {
                continue;
            }
            const std::string name = (is_document ? "relievo:" : "") + std::string(meta.name);
            if (meta.type == RLV_PICTURE_TEXT) {
                spec.attribute(name, string_view(static_cast<const char *>(meta.values), meta.count));
            } else if (meta.count > 0) {
                TypeDesc type = type_of(meta.type);
                type.arraylen = meta.count > 1 ? int(meta.count) : 0;
                spec.attribute(name, type, meta.values);
            }
        }
    }
};

} // namespace

OIIO_PLUGIN_EXPORTS_BEGIN

OIIO_EXPORT int relievo_imageio_version = OIIO_PLUGIN_VERSION;

OIIO_EXPORT const char *relievo_imageio_library_version() { return "Relievo"; }

OIIO_EXPORT ImageInput *relievo_input_imageio_create() { return new RelievoInput; }

// A format that OpenImageIO reads itself goes first.
OIIO_EXPORT const char *relievo_input_extensions[] = {"relievo", "ptx", "ptex", nullptr};

OIIO_PLUGIN_EXPORTS_END

OIIO_PLUGIN_NAMESPACE_END
