// A current OpenGL 4.3 core context without a window, and what was found out about it, once.
//
// One thread owns it: the one that made it. Does not: choose what is drawn, or hold GL objects.
#pragma once

#include "gl/capabilities.h"
#include "gl/first_use.h"

#include <cstdint>
#include <string>
#include <thread>
#include <vector>

namespace clerestory::gl {

enum class Driver { automatic, software, hardware };

struct ContextOptions {
    Driver driver = Driver::automatic;
    bool debugOutput = false;
};

// Objects made since the context was.
struct ObjectCounters {
    std::uint64_t buffers = 0, textures = 0, framebuffers = 0, programs = 0, samplers = 0,
                  vertexArrays = 0;
    std::uint64_t bytesShared = 0;  // of buffers that read the program's own memory
};

class Context {
public:
    // Throws std::runtime_error with one clear line when there is no usable driver.
    explicit Context(const ContextOptions& options);
    ~Context();
    Context(const Context&) = delete;
    Context& operator=(const Context&) = delete;

    // Before any OpenGL call after other contexts may have been current. The owner thread only.
    void makeCurrent();
    static Context& current();

    const Capabilities& capabilities() const { return capabilities_; }
    ObjectCounters& counters() { return counters_; }
    const ObjectCounters& counters() const { return counters_; }
    FirstUse& firstUse() { return firstUse_; }
    const FirstUse& firstUse() const { return firstUse_; }
    const std::vector<std::string>& messages() const { return messages_; }
    void addMessage(std::string message);

    // Throws std::runtime_error if a call has failed since the last check: the frame is then
    // incomplete. Drivers report errors only on request.
    void throwIfFailed();
    // Whether the GPU was reset, as far as the driver tells: nothing that this context holds is
    // there any more, and nothing can be drawn with it.
    bool lost() const;
    // After any failure: forgets what the driver has to say of it.
    void forgive();

private:
    void findCapabilities(const std::string& platform);

    std::thread::id owner_ = std::this_thread::get_id();
    void* display_ = nullptr;
    void* context_ = nullptr;
    void* surface_ = nullptr;
    unsigned (*resetStatus_)() = nullptr;  // null: the driver tells nothing
    Capabilities capabilities_;
    ObjectCounters counters_;
    FirstUse firstUse_;
    std::vector<std::string> messages_;
};

}  // namespace clerestory::gl
