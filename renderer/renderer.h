// The facade of the renderer: it holds scenes and environment maps, plans frames and draws them.
//
// Every member must be called on the thread that created the renderer. Does not open windows, speak
// HTTP or JSON, or read scene files. Threads of its own compute the light of surfaces.
#pragma once

#include "gl/capabilities.h"
#include "image/image.h"
#include "light_state.h"
#include "passes/readback.h"
#include "plan/graph/frame_plan.h"
#include "plan/planner.h"
#include "plan/request/frame_request.h"
#include "scene/environment.h"
#include "scene/scene.h"

#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace clerestory {

enum class Backend { automatic, software, hardware };
// Where a part of a frame is computed; automatic: on the processor if the driver is software.
enum class Computation { automatic, shader, processor };

struct RendererOptions {
    Backend backend = Backend::automatic;
    std::optional<std::uint32_t> device;  // index of gl::devices(); none: the first with a driver
    Computation rays = Computation::automatic;
    Computation display = Computation::automatic;  // tone mapping and edge filter
    LightOptions light;
    bool debugOutput = false;  // collect driver messages; see Renderer::driverMessages
    // Materials that differ in their textures and vertex colours share programs: the same bytes
    // after a shorter compilation, from slower frames. Software drivers only.
    bool fewPrograms = false;
    // Maximum number of samples that a frame shades (plan/graph/work.h); 0: no limit.
    std::uint64_t maxShadedSamples = 0;
    // Called on the renderer's thread when a frame or an upload detects that the GPU was reset, if
    // the driver reports resets; may end the process. After a reset every frame fails.
    std::function<void()> onReset;
    // Called on the renderer's thread with true before and with false after the driver compiles
    // code for a frame.
    std::function<void(bool begins)> onCompiling;
    // Called on the renderer's thread with the plan of a frame before it is drawn; may throw, then
    // nothing is drawn.
    std::function<void(const FramePlan& plan)> beforeDrawing;
};

using RendererIdentity = gl::Capabilities;

struct PassTime {
    std::string kind, name;
    double milliseconds = 0.0;
    std::uint64_t paths = 0;  // of rays that the processor followed
};

// Counts of invalid texels over all levels and faces of a float target.
struct TargetHealth {
    std::string target;           // its name in the plan
    std::uint64_t texels = 0;     // checked
    std::uint64_t nonFinite = 0;  // with a NaN or an infinity
    std::uint64_t negative = 0;   // finite, with negative light
};

// What the channel instances says of an instance.
struct LabelledInstance {
    InstanceExtent extent;
    std::string node;  // its name
    glm::dmat4 worldFromModel{1.0};
    std::uint32_t materialId = 0, classId = 0;
};

struct Frame {
    Image image;
    FramePlan plan;
    std::vector<PassTime> passTimes;  // in the order of plan.passes
    LightProgress light;
    // What the same request would show now, on any thread; empty if it needs no light of surfaces.
    std::function<LightProgress()> lightNow;
    double planMs = 0.0;
    double readbackMs = 0.0;
    double compileMs = 0.0;      // time of compilation within the frame
    std::uint64_t compiled = 0;  // programs and pipelines; see RendererCounters
    std::uint64_t mapBytes = 0;  // resident data that the frame uses
    // Number of the addScene() call of this renderer, from 1, that added the scene.
    std::uint64_t sceneGeneration = 0;
    std::vector<TargetHealth> health;         // Readback::health
    std::vector<MapPicture> maps;             // Readback::maps
    std::vector<LabelledInstance> instances;  // of the channel instances
};

// Objects created and work submitted to OpenGL since start.
struct RendererCounters {
    std::uint64_t frames = 0, drawCalls = 0, triangles = 0;
    std::uint64_t meshesMoved = 0;     // uploads of deformed meshes
    std::uint64_t paths = 0;           // of rays that the processor followed
    std::uint64_t lightsComputed = 0;  // between surfaces; not those found on disk
    std::uint64_t texturesMade = 0, framebuffersMade = 0, programsMade = 0, buffersMade = 0;
    std::uint64_t bytesShared = 0;  // of vertices and indices that the driver reads without a copy
    // Combinations of program, fixed state and target format that were drawn for the first time,
    // and the time for compiling programs and combinations.
    std::uint64_t pipelinesMade = 0;
    double compileMilliseconds = 0.0;
};

class WarmUpPlanner;

// Progress of compiling the programs of some frames in advance; see Renderer::beginWarmUp().
class WarmUp {
public:
    std::size_t done() const { return done_; }  // in passes, about one for each program
    std::size_t total() const;

private:
    friend class Renderer;
    struct Plan;
    std::vector<std::shared_ptr<const Plan>> plans_;
    std::shared_ptr<WarmUpPlanner> planner_;
    std::size_t done_ = 0;
};

// The driver failed or memory was exhausted during a frame. Everything that the frame created was
// released, and later frames are not affected, unless the GPU was reset, which loses all content.
class RenderFailed : public std::runtime_error {
public:
    using std::runtime_error::runtime_error;
};

// The frame is not needed any more; see Renderer::render().
class FrameAbandoned : public std::runtime_error {
public:
    FrameAbandoned() : std::runtime_error("the frame was abandoned") {}
};

class Renderer {
public:
    // Throws std::runtime_error with a one-line message if there is no usable driver.
    explicit Renderer(const RendererOptions& options);
    ~Renderer();
    Renderer(const Renderer&) = delete;
    Renderer& operator=(const Renderer&) = delete;

    const RendererIdentity& identity() const;

    // Adding replaces a scene of the same id or a map of the same name. A scene is uploaded
    // immediately, and its texels in main memory are freed; a map is uploaded when it is first
    // drawn. addScene() throws if the driver fails, RenderFailed if the GPU was reset.
    void addScene(Scene scene);
    void removeScene(const std::string& id);
    bool hasScene(const std::string& id) const;
    void addEnvironment(std::shared_ptr<const EnvironmentMap> map);
    // No effect if another map has its name now.
    void removeEnvironment(const EnvironmentMap& map);
    std::vector<std::string> environmentNames() const;

    // Throws InvalidRequest if problems(request) is not empty or the request names an unknown
    // scene, camera, clip or map.
    FramePlan plan(const FrameRequest& request) const;
    // Draws a frame. Its bytes depend neither on earlier frames nor on `readback`; Readback::health
    // doubles the time. Throws InvalidRequest as plan() does and if the plan exceeds
    // RendererOptions::maxShadedSamples, before anything is drawn; RenderFailed if the driver
    // fails.
    // `abandoned` is called before each pass and within long ones; once it returns true the frame
    // ends with FrameAbandoned, and later frames are not affected.
    Frame render(const FrameRequest& request, Readback readback = Readback::picture,
                 const std::function<bool()>& abandoned = {});

    // Begins the computation of the light of surfaces that earlier frames needed, as the next frame
    // does. Call it when their pictures are on their way. May throw RenderFailed.
    void beginNeededLights();
    // Begins the computation of the light of surfaces if the request needs it. Throws
    // InvalidRequest as plan() does.
    LightState light(const FrameRequest& request);
    // The same, and waits until it is complete or `abandoned` returns true.
    LightState completeLight(const FrameRequest& request,
                             const std::function<bool()>& abandoned = {});

    // Releases all resident maps (prefiltered environment maps and captured cubes). Later frames
    // draw them again and have the same bytes.
    void forgetMaps();

    // Frees what a frame leaves for the next one to reuse, apart from resident maps: targets and
    // copies of shadow maps (150 MB at 1280x720 in the chapel), tables for rays of scenes that no
    // frame shows, and maps of meshes that were refined since. The next frame makes what it needs
    // again.
    void releaseScratch();
    // Frees the compiled programs. The next frame makes its own again, of which a driver with a
    // cache compiles none.
    void releasePrograms();

    // Frees the driver's tables for compiling shaders (7 MB). The next program fills them again
    // within milliseconds.
    void releaseCompiler();

    // Whether the programs of a scene were probably never compiled on this machine; false when it
    // is added. While it is true for any scene, other contexts find what this one compiles for new
    // programs, but programs that are in the driver's cache take longer.
    void expectCompilation(const std::string& scene, bool expected);

    // Compiles the programs of these frames in advance by drawing them into small targets, in steps
    // between which frames can be drawn:
    //
    //     WarmUp warmUp = renderer.beginWarmUp(firstFramesOf(scene));
    //     while (renderer.advance(warmUp)) {}
    //
    // Throws InvalidRequest as plan() does.
    WarmUp beginWarmUp(const std::vector<FrameRequest>& frames) const;
    // Adds the programs of one more frame that the frames before it do not have.
    void extend(WarmUp& warmUp, const FrameRequest& frame) const;
    // Performs one step. Returns false if no step is left or the scene was removed. May throw
    // RenderFailed. `fromTheEnd`: last steps first.
    bool advance(WarmUp& warmUp, bool fromTheEnd = false);

    RendererCounters counters() const;
    std::vector<std::string> driverMessages() const;  // empty without debugOutput or errors

private:
    friend class WarmUp;
    struct State;
    std::unique_ptr<State> state_;
};

// Shuts down the driver when no Renderer exists, so that it writes pending compiled shaders to its
// cache. Call it at the end of a process; a later Renderer starts the driver again.
void endDriver();

// Likely first requests of a client: the default view at two presets, and the whole scene from a
// distance.
std::vector<FrameRequest> firstFramesOf(const Scene& scene);
// Likely later requests: from around the default view, at two presets, and in motion.
std::vector<FrameRequest> nearbyFramesOf(const Scene& scene);

}  // namespace clerestory
