// An object of the host: a cage, the detail on it, and the document that keeps its edits in the host's scene.
#pragma once

#include <relievo/relievo.hpp>

#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

namespace studio {

using Blob = std::vector<std::uint8_t>;

/// A part of the scene that a document lives in: every edit is written here before it ends.
class Section : public relievo::Storage {
public:
    explicit Section(Blob bytes = {}) : bytes_(std::move(bytes)) {}

    void read(std::uint64_t place, std::uint8_t *bytes, std::size_t size) override;
    void write(std::uint64_t place, const std::uint8_t *bytes, std::size_t size) override;
    std::uint64_t length() override;
    void cut(std::uint64_t length) override;

    /// What there is now, for the file of the scene.
    Blob copy() const;

private:
    mutable std::mutex lock_;
    Blob bytes_;
};

struct Object {
    std::string name;
    relievo::Matrix place;
    relievo::Mesh cage;
    relievo::Detail detail;
    std::shared_ptr<Section> section;
    relievo::Document document;

    /// Makes an object of a cage. With `journal`, the bytes of a document, it has the edits of that.
    static Object create(const relievo::Context &context, std::string name, const relievo::Mesh &cage,
                         const relievo::Matrix &place, Blob journal = {});

    /// Makes `work`, which edits the detail, one edit of the document, and shows it.
    void edit(const std::string &input, const std::function<void()> &work) const;
};

} // namespace studio
