#include "scene_file.hpp"

#include <array>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <stdexcept>

namespace studio {

namespace {

constexpr std::array<char, 8> MAGIC = {'S', 'T', 'U', 'D', 'I', 'O', '0', '1'};

class Writer {
public:
    template <class Value> void value(const Value &value) { append(&value, sizeof value); }

    void append(const void *bytes, std::size_t size) {
        const auto *first = static_cast<const std::uint8_t *>(bytes);
        bytes_.insert(bytes_.end(), first, first + size);
    }

    /// A size, then as many bytes.
    void part(const void *bytes, std::size_t size) {
        value(static_cast<std::uint64_t>(size));
        append(bytes, size);
    }

    const Blob &bytes() const { return bytes_; }

private:
    Blob bytes_;
};

class Reader {
public:
    Reader(std::string path, Blob bytes) : path_(std::move(path)), bytes_(std::move(bytes)) {}

    template <class Value> Value value() {
        Value value;
        std::memcpy(&value, take(sizeof value), sizeof value);
        return value;
    }

    Blob part() {
        const auto size = value<std::uint64_t>();
        if (size > left()) {
            fail();
        }
        const std::uint8_t *first = take(static_cast<std::size_t>(size));
        return Blob(first, first + size);
    }

    std::size_t left() const { return bytes_.size() - place_; }

    [[noreturn]] void fail() const { throw std::runtime_error(path_ + " is no scene, or ends too early"); }

private:
    const std::uint8_t *take(std::size_t size) {
        if (size > left()) {
            fail();
        }
        place_ += size;
        return bytes_.data() + place_ - size;
    }

    std::string path_;
    Blob bytes_;
    std::size_t place_ = 0;
};

} // namespace

void save_scene(const std::string &path, const std::vector<Object> &objects) {
    Writer writer;
    writer.value(MAGIC);
    writer.value(static_cast<std::uint64_t>(objects.size()));
    for (const Object &object : objects) {
        writer.part(object.name.data(), object.name.size());
        writer.value(object.place);
        const relievo::Bytes cage = object.cage.write_bytes("ply");
        writer.part(cage.data(), cage.size());
        const Blob journal = object.section->copy();
        writer.part(journal.data(), journal.size());
    }
    const std::string beside = path + ".new";
    std::ofstream file(beside, std::ios::binary);
    file.write(reinterpret_cast<const char *>(writer.bytes().data()), static_cast<std::streamsize>(writer.bytes().size()));
    file.close();
    if (!file) {
        throw std::runtime_error("cannot write " + beside);
    }
    std::filesystem::rename(beside, path);
}

std::vector<Object> open_scene(const relievo::Context &context, const std::string &path) {
    std::ifstream file(path, std::ios::binary);
    if (!file) {
        throw std::runtime_error("cannot read " + path);
    }
    Reader reader(path, Blob(std::istreambuf_iterator<char>(file), {}));
    if (reader.value<std::array<char, 8>>() != MAGIC) {
        reader.fail();
    }
    std::vector<Object> objects;
    const auto count = reader.value<std::uint64_t>();
    for (std::uint64_t k = 0; k < count; ++k) {
        const Blob name = reader.part();
        const auto place = reader.value<relievo::Matrix>();
        const Blob ply = reader.part();
        const auto cage = relievo::Mesh::read_bytes(context, "ply", ply.data(), ply.size());
        objects.push_back(Object::create(context, std::string(name.begin(), name.end()), cage, place, reader.part()));
    }
    return objects;
}

} // namespace studio
