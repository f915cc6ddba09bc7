// Stops frames after they are planned and before their first pass, so that a test can act while a
// frame is in progress:
//
//     DrawingGate gate;
//     Config config = testConfig();
//     config.renderer.beforeDrawing = gate.whenPlanned();
//     TestServer server(config);
//     gate.close();
//     ...                   // requests a frame
//     gate.awaitFrame();    // it is in progress
//     ...                   // acts
//     gate.open();          // its passes begin
#pragma once

#include <condition_variable>
#include <functional>
#include <mutex>

namespace clerestory {
struct FramePlan;
}

namespace clerestory::test {

class DrawingGate {
public:
    // The gate must outlive the renderer that calls it.
    std::function<void(const FramePlan&)> whenPlanned() {
        return [this](const FramePlan&) { pass(); };
    }

    void close() {
        const std::lock_guard lock(mutex_);
        closed_ = true;
    }

    void open() {
        const std::lock_guard lock(mutex_);
        closed_ = false;
        changed_.notify_all();
    }

    // Returns when a frame waits at the closed gate.
    void awaitFrame() {
        std::unique_lock lock(mutex_);
        changed_.wait(lock, [&] { return waiting_; });
    }

private:
    void pass() {
        std::unique_lock lock(mutex_);
        waiting_ = closed_;
        changed_.notify_all();
        changed_.wait(lock, [&] { return !closed_; });
        waiting_ = false;
    }

    std::mutex mutex_;
    std::condition_variable changed_;
    bool closed_ = false, waiting_ = false;
};

}  // namespace clerestory::test
