// The threads of the host: a pool that runs its own work, and all loops and jobs of the library.
#pragma once

#include <relievo/relievo.h>

#include <atomic>
#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace studio {

class Pool {
public:
    /// Starts `threads` - 1 workers, and one at least: the thread that calls loop() is the other one.
    explicit Pool(unsigned threads);
    ~Pool();
    Pool(const Pool &) = delete;
    Pool &operator=(const Pool &) = delete;

    /// Calls body(index) for every index below count, on any threads, and returns when all are done. Loops within loops
    /// are allowed.
    void loop(std::size_t count, const std::function<void(std::size_t)> &body);

    /// Runs a task on a worker, some time.
    void spawn(std::function<void()> task);

    /// How many loops of the library it has run.
    std::size_t library_loops() const { return library_loops_; }

    unsigned threads() const { return static_cast<unsigned>(workers_.size()) + 1; }

    /// Makes the options of a context that works on this pool; `device` is an RlvDevice.
    RlvContextOptions options(RlvDevice device);

private:
    struct Loop;

    void serve();
    static void take(Loop &loop);

    std::mutex lock_;
    std::condition_variable changed_;
    std::vector<Loop *> loops_;
    std::deque<std::function<void()>> tasks_;
    std::vector<std::thread> workers_;
    bool ends_ = false;
    std::atomic<std::size_t> library_loops_{0};
};

} // namespace studio
