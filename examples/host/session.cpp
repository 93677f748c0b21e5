#include "session.hpp"

#include "scene_file.hpp"

namespace studio {

Session::Session(relievo::Context context, const std::string &path) : Session(std::move(context)) {
    objects_ = open_scene(context_, path);
}

void Session::save(const std::string &path) const { save_scene(path, objects_); }

std::size_t Session::add(const std::string &name, const relievo::Mesh &cage, const relievo::Matrix &place) {
    objects_.push_back(Object::create(context_, name, cage, place));
    return objects_.size() - 1;
}

void Session::place(std::size_t object, const relievo::Matrix &place) {
    objects_[object].detail.set_transform(place);
    objects_[object].detail.commit();
    objects_[object].place = place;
}

History::Step Session::moved(std::size_t object, const relievo::Matrix &to) {
    const relievo::Matrix from = objects_[object].place;
    place(object, to);
    return {"move " + objects_[object].name, [=] { place(object, from); }, [=] { place(object, to); }};
}

History::Step Session::edited(std::size_t object, const std::string &name, const std::function<void()> &work) {
    objects_[object].edit(name, work);
    const auto undo = [this, object] {
        objects_[object].document.undo();
        objects_[object].detail.commit();
    };
    const auto redo = [this, object] {
        objects_[object].document.redo();
        objects_[object].detail.commit();
    };
    return {name, undo, redo};
}

void Session::move(std::size_t object, const relievo::Matrix &to) { history_.add(moved(object, to)); }

void Session::stroke(std::size_t object, const RlvBrushOptions &brush, const RlvBrushSettings &settings,
                     const std::vector<RlvStrokePoint> &points) {
    const auto made = relievo::Brush::create(context_, brush, settings);
    history_.add(edited(object, "stroke on " + objects_[object].name,
                        [&] { relievo::stroke(objects_[object].detail, made, points); }));
}

void Session::press(std::size_t tool, std::size_t into, const relievo::Matrix &to) {
    const auto collider = relievo::Collider::create(objects_[tool].detail);
    const relievo::Matrix from = objects_[tool].place;
    const auto dent = edited(into, "press " + objects_[tool].name + " into " + objects_[into].name,
                             [&] { relievo::sweep(objects_[into].detail, collider, from, to); });
    const auto way = moved(tool, to);
    // What the user sees as one change is one step.
    history_.add({dent.name,
                  [=] {
                      way.undo();
                      dent.undo();
                  },
                  [=] {
                      dent.redo();
                      way.redo();
                  }});
}

relievo::Mesh Session::triangles(std::size_t object) const {
    return relievo::Job::tessellate(objects_[object].detail).take();
}

} // namespace studio
