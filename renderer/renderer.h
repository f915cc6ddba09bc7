// The facade of the renderer: scenes and environment maps in, frames out.
//
// All of it belongs to the one thread that made it. Does not: open windows, speak HTTP or JSON,
// start threads, read scene files.
#pragma once

#include "image/image.h"
#include "passes/readback.h"
#include "plan/graph/frame_plan.h"
#include "plan/planner.h"
#include "plan/request/frame_request.h"
#include "scene/environment.h"
#include "scene/scene.h"

#include <filesystem>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace clerestory {

enum class Backend { automatic, software, hardware };

struct RendererOptions {
    Backend backend = Backend::automatic;
    bool debugOutput = false;  // collect driver messages; see Renderer::driverMessages
    // That a frame may shade, as plan/graph/work.h counts them; 0: any.
    std::uint64_t mostSamples = 0;
    // Called on the renderer's thread by a frame, or a scene, that finds the GPU was reset, as far
    // as the driver tells; it may end the process. Without it every frame fails from then on.
    std::function<void()> whenReset;
    // Called on the renderer's thread with true before and with false after the driver compiles
    // something for a frame.
    std::function<void(bool begins)> whenCompiling;
};

// What was found, as the driver says it.
struct RendererIdentity {
    std::string vendor, renderer, version, shadingLanguage;
    std::string platform;  // "surfaceless", "device" or "pbuffer"
    bool software = false;
    bool clipControl = false;          // reversed depth at full precision
    bool timerQueriesTrusted = false;  // their clock agreed with a wall clock at start
    bool tellsOfResets = false;        // of the GPU
    bool readsClientMemory = false;    // vertices and indices are held once, not twice
    std::uint32_t maxSamples = 1, maxAnisotropy = 1, maxTextureSize = 0;
};

struct PassTime {
    std::string kind, name;
    double milliseconds = 0.0;
};

// What must not be in a picture, counted over all levels and faces of one float target.
struct TargetHealth {
    std::string target;           // its name in the plan
    std::uint64_t texels = 0;     // looked at
    std::uint64_t nonFinite = 0;  // with a NaN or an infinity
    std::uint64_t negative = 0;   // of the others: with negative light
};

// What a frame's mirrors look at; see passes/map_pictures.h for how it lies.
struct FrameMap {
    std::string target;  // its name in the plan
    Image picture;       // float32, 3 channels, linear radiance
};

struct Frame {
    Image image;
    FramePlan plan;
    std::vector<PassTime> passTimes;  // in the order of plan.passes
    double planMs = 0.0;
    double readbackMs = 0.0;
    double compileMs = 0.0;      // of planning to readback, what compiling took
    std::uint64_t compiled = 0;  // programs and pipelines; see RendererCounters
    std::uint64_t mapBytes = 0;  // kept for this scene and read by this frame
    // Which addScene() of this renderer, from 1, the scene came from that was drawn.
    std::uint64_t sceneGeneration = 0;
    std::vector<TargetHealth> health;  // Readback::health
    std::vector<FrameMap> maps;        // Readback::maps
};

// Objects made and work asked of OpenGL since start; tests hold plans against these.
struct RendererCounters {
    std::uint64_t frames = 0, drawCalls = 0, triangles = 0;
    std::uint64_t meshesMoved = 0;  // whose vertices were uploaded anew, because they deform
    std::uint64_t texturesMade = 0, framebuffersMade = 0, programsMade = 0, buffersMade = 0;
    std::uint64_t bytesShared = 0;  // of vertices and indices that the driver reads without a copy
    // Combinations of program, fixed state and target format drawn for the first time, and what
    // compiling programs and combinations took.
    std::uint64_t pipelinesMade = 0;
    double compileMilliseconds = 0.0;
};

// What is left to compile of what some frames will draw; see Renderer::beginWarmUp.
class WarmUp {
public:
    std::size_t done() const { return done_; }  // passes, about one for each program
    std::size_t total() const;

private:
    friend class Renderer;
    struct Plan;
    std::vector<std::shared_ptr<const Plan>> plans_;
    std::size_t done_ = 0;
};

// The driver, or the memory, failed in the middle of a frame. What the frame had made was let go:
// the next one is drawn as if this one had never been; but for a GPU that was reset, with which all
// is gone.
class RenderFailed : public std::runtime_error {
public:
    using std::runtime_error::runtime_error;
};

class Renderer {
public:
    // Throws std::runtime_error with one clear line when there is no usable driver.
    explicit Renderer(const RendererOptions& options);
    ~Renderer();
    Renderer(const Renderer&) = delete;
    Renderer& operator=(const Renderer&) = delete;

    const RendererIdentity& identity() const;

    // Both replace what had the same id or name. A scene is uploaded at once, and the pixels of its
    // textures live on the GPU alone from then on; a map is uploaded when first drawn.
    void addScene(Scene scene);
    void removeScene(const std::string& id);
    bool hasScene(const std::string& id) const;
    void addEnvironment(std::shared_ptr<const EnvironmentMap> map);
    std::vector<std::string> environmentNames() const;

    // Throw InvalidRequest when the request names a scene, camera or map that is not there.
    FramePlan plan(const FrameRequest& request) const;
    // The same picture, byte for byte, whatever is brought back beside it; Readback::health takes
    // about as long again. May throw RenderFailed, and InvalidRequest, before anything is made,
    // when the plan shades more than RendererOptions allow.
    Frame render(const FrameRequest& request, Readback readback = Readback::picture);

    // Lets go of every map that outlives its frame, prefiltered environment maps and captured
    // cubes: the next frame draws anew what it needs of them. The same request gives the same
    // bytes.
    void forgetMaps();

    // Frees the driver's tables for compiling shaders (7 MB). The next program that is made fills
    // them again, in some milliseconds.
    void releaseCompiler();

    // Draws what these frames will, so small that compilation is all it costs, so that the real
    // ones wait for nothing. In steps, so that frames come in between:
    //
    //     WarmUp warmUp = renderer.beginWarmUp(firstFramesOf("chapel"));
    //     while (renderer.advance(warmUp)) {}
    //
    // Throws InvalidRequest as plan() does.
    WarmUp beginWarmUp(const std::vector<FrameRequest>& frames) const;
    // False when nothing is left, or the scene is no longer there. May throw RenderFailed.
    // `fromTheEnd` takes the last steps first.
    bool advance(WarmUp& warmUp, bool fromTheEnd = false);

    RendererCounters counters() const;
    std::vector<std::string> driverMessages() const;  // empty means health

private:
    friend class WarmUp;
    struct State;
    std::unique_ptr<State> state_;
};

// At the end of a process, when no Renderer is left: ends the driver, which otherwise drops the
// compiled shaders that it has not yet written to its cache. A Renderer made later starts it again.
void endDriver();

// The frames that a client most likely asks for first: the default view at two accuracies, and all
// of the scene from afar.
std::vector<FrameRequest> firstFramesOf(const Scene& scene);

}  // namespace clerestory
