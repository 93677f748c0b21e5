// A session of the host: a scene that is edited, with everything undone in one order.
#pragma once

#include "history.hpp"
#include "object.hpp"

namespace studio {

class Session {
public:
    /// A new scene, whose work is done in `context`.
    explicit Session(relievo::Context context) : context_(std::move(context)) {}

    /// A scene of a file. Its documents bring their own histories; the session's begins anew.
    Session(relievo::Context context, const std::string &path);
    // Steps of the history refer to their session.
    Session(const Session &) = delete;
    Session &operator=(const Session &) = delete;

    void save(const std::string &path) const;

    const relievo::Context &context() const { return context_; }
    const std::vector<Object> &objects() const { return objects_; }

    /// Adds an object and returns its number.
    std::size_t add(const std::string &name, const relievo::Mesh &cage, const relievo::Matrix &place);

    /// Moves an object: a change of the host's own.
    void move(std::size_t object, const relievo::Matrix &place);

    /// Draws a stroke on an object.
    void stroke(std::size_t object, const RlvBrushOptions &brush, const RlvBrushSettings &settings,
                const std::vector<RlvStrokePoint> &points);

    /// Presses one object into another on its way from where it is to `place`, where it stays.
    void press(std::size_t tool, std::size_t into, const relievo::Matrix &place);

    bool undo() { return history_.undo(); }
    bool redo() { return history_.redo(); }
    std::size_t steps() const { return history_.size(); }

    /// Makes the triangles that an object shows now, by a job on the pool.
    relievo::Mesh triangles(std::size_t object) const;

private:
    void place(std::size_t object, const relievo::Matrix &place);
    /// Moves an object; the result undoes that and does it again.
    History::Step moved(std::size_t object, const relievo::Matrix &to);
    /// Makes `work` an edit of an object's document; the result undoes that and does it again.
    History::Step edited(std::size_t object, const std::string &name, const std::function<void()> &work);

    relievo::Context context_;
    std::vector<Object> objects_;
    History history_;
};

} // namespace studio
