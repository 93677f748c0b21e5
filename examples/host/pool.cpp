#include "pool.hpp"

#include <algorithm>
#include <atomic>

namespace studio {

/// A loop under way, on the stack of the thread that began it.
struct Pool::Loop {
    std::size_t count;
    const std::function<void(std::size_t)> &body;
    std::atomic<std::size_t> next{0};
    /// Workers that are in the loop; the pool's lock guards it.
    std::size_t visitors = 0;
};

Pool::Pool(unsigned threads) {
    for (unsigned k = 1; k < std::max(threads, 2u); ++k) {
        workers_.emplace_back([this] { serve(); });
    }
}

Pool::~Pool() {
    {
        const std::lock_guard<std::mutex> guard(lock_);
        ends_ = true;
    }
    changed_.notify_all();
    for (std::thread &worker : workers_) {
        worker.join();
    }
}

void Pool::take(Loop &loop) {
    for (std::size_t index = loop.next++; index < loop.count; index = loop.next++) {
        loop.body(index);
    }
}

void Pool::loop(std::size_t count, const std::function<void(std::size_t)> &body) {
    Loop loop{count, body};
    {
        const std::lock_guard<std::mutex> guard(lock_);
        loops_.push_back(&loop);
    }
    changed_.notify_all();
    take(loop);
    // Nobody begins with it any more; threads that have begun are waited for.
    std::unique_lock<std::mutex> guard(lock_);
    loops_.erase(std::find(loops_.begin(), loops_.end(), &loop));
    changed_.wait(guard, [&loop] { return loop.visitors == 0; });
}

void Pool::spawn(std::function<void()> task) {
    {
        const std::lock_guard<std::mutex> guard(lock_);
        tasks_.push_back(std::move(task));
    }
    changed_.notify_all();
}

void Pool::serve() {
    std::unique_lock<std::mutex> guard(lock_);
    const auto open = [this] {
        return std::find_if(loops_.rbegin(), loops_.rend(), [](const Loop *loop) { return loop->next < loop->count; });
    };
    while (true) {
        // Loops come before tasks, since somebody waits for them; the newest first, since the older ones may wait for it.
        const auto found = open();
        if (found != loops_.rend()) {
            Loop &loop = **found;
            ++loop.visitors;
            guard.unlock();
            take(loop);
            guard.lock();
            if (--loop.visitors == 0) {
                changed_.notify_all();
            }
        } else if (!tasks_.empty()) {
            const auto task = std::move(tasks_.front());
            tasks_.pop_front();
            guard.unlock();
            task();
            guard.lock();
        } else if (ends_) {
            return;
        } else {
            changed_.wait(guard);
        }
    }
}

RlvContextOptions Pool::options(RlvDevice device) {
    RlvContextOptions options = RLV_CONTEXT_OPTIONS_INIT;
    options.device = device;
    options.threads = threads();
    options.host_loop = [](void *user, std::size_t count, RlvLoopBody body, void *work) {
        Pool &pool = *static_cast<Pool *>(user);
        ++pool.library_loops_;
        pool.loop(count, [body, work](std::size_t index) { body(work, index); });
    };
    options.host_spawn = [](void *user, RlvTask task, void *work) {
        static_cast<Pool *>(user)->spawn([task, work] { task(work); });
    };
    options.host_user = this;
    return options;
}

} // namespace studio
