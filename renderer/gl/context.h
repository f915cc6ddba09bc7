// A current OpenGL 4.3 core context without a window, what was found out about it, and how drivers
// are opened.
//
// One thread owns a context: the one that made it. Does not: choose what is drawn, or hold GL
// objects.
#pragma once

#include "gl/capabilities.h"

#include <cstdint>
#include <functional>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <tuple>
#include <vector>

namespace clerestory::gl {

// Detects and times compilation. A driver compiles a program when it is linked, and again, without
// a request, inside the first draw with each combination of program, fixed state and target
// format. llvmpipe takes 0.1 to 1 s for each. FirstUse times both, so that this time can be
// reported as compilation.

struct CompileCounters {
    std::uint64_t programs = 0;   // linked
    std::uint64_t pipelines = 0;  // combinations that were drawn for the first time
    double milliseconds = 0.0;    // that both took; a draw that found its code in a cache included
};

class FirstUse {
public:
    // Called on the context's thread with true before and with false after each compilation.
    std::function<void(bool begins)> whenCompiling;
    // The driver has probably cached none of the next programs; see ProgramDescription::loadBinary.
    bool programsAreNew = false;

    const CompileCounters& counters() const { return counters_; }

    // Call when programs were deleted: the names of later ones may be the same.
    void forgetPipelines() {
        seen_.clear();
        known_ = false;
    }

    // What the next draw uses. `state` and `target`: any numbers that are equal for equal state.
    void setProgram(std::uint32_t name) { set(program_, name); }
    void setState(std::uint32_t state) { set(state_, state); }
    void setTarget(std::uint32_t target) { set(target_, target); }

    // Runs `call`, which begins to compile a program or waits for its end.
    template <class Call>
    auto compile(Call&& call) {
        const Timed timed(*this);
        return call();
    }
    void countProgram() { ++counters_.programs; }
    // Runs `call`, which draws; watches it if it is the first with this combination.
    template <class Call>
    void draw(Call&& call) {
        if (known_) return call();
        known_ = true;
        if (!seen_.emplace(program_, state_, target_).second) return call();
        ++counters_.pipelines;
        const Timed timed(*this);
        call();
    }

private:
    class Timed {
    public:
        explicit Timed(FirstUse& use);
        ~Timed();
        Timed(const Timed&) = delete;
        Timed& operator=(const Timed&) = delete;

    private:
        FirstUse& use_;
        std::int64_t begin_;  // nanoseconds
    };

    void set(std::uint32_t& value, std::uint32_t to) {
        known_ = known_ && value == to;
        value = to;
    }

    std::uint32_t program_ = 0, state_ = 0, target_ = 0;
    bool known_ = false;  // the combination at hand was drawn before
    std::set<std::tuple<std::uint32_t, std::uint32_t, std::uint32_t>> seen_;
    CompileCounters counters_;
};

enum class Driver { automatic, software, hardware };

struct ContextOptions {
    Driver driver = Driver::automatic;
    std::optional<std::uint32_t> device;  // index of devices(); none: the first that has a driver
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
    // Whether the GPU was reset, if the driver reports resets: all objects of this context are
    // lost, and nothing can be drawn with it.
    bool lost() const;
    // After any failure: discards the pending errors of the driver.
    void discardErrors();

private:
    void findCapabilities(const std::string& platform);

    std::thread::id owner_ = std::this_thread::get_id();
    void* display_ = nullptr;
    void* context_ = nullptr;
    void* surface_ = nullptr;
    unsigned (*resetStatus_)() = nullptr;  // null: the driver does not report resets
    Capabilities capabilities_;
    ObjectCounters counters_;
    FirstUse firstUse_;
    std::vector<std::string> messages_;
};

// A context that was made and is current, not yet owned by a Context.
struct OpenedContext {
    void* display = nullptr;
    void* context = nullptr;
    void* surface = nullptr;  // only where a context needs one
    std::string platform;
};

// Throws std::runtime_error with a one-line message if there is no usable driver of the requested
// kind or on the requested device.
OpenedContext openContext(const ContextOptions& options);
void closeContext(const OpenedContext& opened);

// Terminates every display that was opened. No context of the process may exist.
void closeDisplays();

// From GL_RENDERER.
bool isSoftwareRenderer(const std::string& renderer);

}  // namespace clerestory::gl
