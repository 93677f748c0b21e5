// What the host can undo: its own changes, and edits of documents, in the order in which they were made.
#pragma once

#include <functional>
#include <string>
#include <vector>

namespace studio {

class History {
public:
    struct Step {
        std::string name;
        std::function<void()> undo, redo;
    };

    /// Notes a step that was done. What was undone before it cannot be done again.
    void add(Step step) {
        steps_.resize(done_);
        steps_.push_back(std::move(step));
        ++done_;
    }

    /// Undoes the last step; false where nothing was done. If it fails, it counts as done.
    bool undo() {
        if (done_ == 0) {
            return false;
        }
        steps_[done_ - 1].undo();
        --done_;
        return true;
    }

    /// Does the step again that was undone last; false where there is none.
    bool redo() {
        if (done_ == steps_.size()) {
            return false;
        }
        steps_[done_].redo();
        ++done_;
        return true;
    }

    std::size_t size() const { return done_; }

private:
    std::vector<Step> steps_;
    std::size_t done_ = 0;
};

} // namespace studio
