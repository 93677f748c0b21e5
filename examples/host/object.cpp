#include "object.hpp"

#include <algorithm>
#include <stdexcept>

namespace studio {

void Section::read(std::uint64_t place, std::uint8_t *bytes, std::size_t size) {
    const std::lock_guard<std::mutex> guard(lock_);
    if (place > bytes_.size() || size > bytes_.size() - place) {
        throw std::out_of_range("the section ends before that");
    }
    std::copy_n(bytes_.begin() + static_cast<std::ptrdiff_t>(place), size, bytes);
}

void Section::write(std::uint64_t place, const std::uint8_t *bytes, std::size_t size) {
    const std::lock_guard<std::mutex> guard(lock_);
    bytes_.resize(std::max(bytes_.size(), static_cast<std::size_t>(place) + size));
    std::copy_n(bytes, size, bytes_.begin() + static_cast<std::ptrdiff_t>(place));
}

std::uint64_t Section::length() {
    const std::lock_guard<std::mutex> guard(lock_);
    return bytes_.size();
}

void Section::cut(std::uint64_t length) {
    const std::lock_guard<std::mutex> guard(lock_);
    bytes_.resize(static_cast<std::size_t>(length));
}

Blob Section::copy() const {
    const std::lock_guard<std::mutex> guard(lock_);
    return bytes_;
}

Object Object::create(const relievo::Context &context, std::string name, const relievo::Mesh &cage,
                      const relievo::Matrix &place, Blob journal) {
    RlvDetailOptions options = RLV_DETAIL_OPTIONS_INIT;
    options.tile_size = 64;
    const bool is_new = journal.empty();
    Object made;
    made.name = std::move(name);
    made.place = place;
    made.cage = cage;
    made.detail = relievo::Detail::create(relievo::Surface::create(context, cage), options, place);
    made.section = std::make_shared<Section>(std::move(journal));
    if (is_new) {
        RlvPaintOptions paint = RLV_PAINT_OPTIONS_INIT;
        paint.tile_size = 64;
        made.detail.add_paint(paint);
        made.document = relievo::Document::create(made.detail, made.section);
    } else {
        // The document brings its layers, those of colour among them.
        made.document = relievo::Document::open(made.detail, made.section);
    }
    made.detail.commit();
    return made;
}

void Object::edit(const std::string &input, const std::function<void()> &work) const {
    document.edit(input, work);
    detail.commit();
}

} // namespace studio
