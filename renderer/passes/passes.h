// Execution of each pass type. A pass sets all OpenGL state that it uses, relies on nothing that an
// earlier pass left, and reads only the plan, never the request.
#pragma once

#include "light/surface_light.h"
#include "passes/draw_stream.h"
#include "passes/gpu_environment.h"
#include "passes/gpu_scene.h"
#include "passes/gpu_tracer.h"
#include "passes/lens_lookups.h"
#include "passes/processor_tracer.h"
#include "passes/readback.h"
#include "passes/shader_library.h"
#include "passes/supersampler.h"
#include "passes/targets.h"

#include <functional>
#include <optional>
#include <span>

namespace clerestory {

struct DrawCounters {
    std::uint64_t drawCalls = 0, triangles = 0;  // of the scene; full-screen triangles not counted
    std::uint64_t meshesMoved = 0;               // see GpuScene::follow()
    std::uint64_t paths = 0;                     // of rays, followed on the processor
};

// Objects that passes share from frame to frame.
struct PassResources {
    PassResources();

    ShaderLibrary shaders;
    SamplerCache samplers;
    DrawStream draws;
    MaterialBlocks frameMaterials;
    gl::Buffer viewBlock, reflectionBlock, prefilterBlock, filterBlock;
    gl::VertexArray noVertices;
    LensLookups lensLookups;
    gl::Texture environmentBrdf;
    gl::Texture darkness;                 // a black cube, for plans without an environment
    std::vector<std::uint64_t> radiance;  // halves of a picture, read back for tone mapping
    Supersampler supersampler;
    DrawCounters counters;
    std::vector<InstanceExtent> instances;  // of MeasureInstances and CountLayer
    bool interrupted = false;               // see isInterrupted()
};

// A further sample of chosen pixels of a frame: a pass draws in these pixels only, displaced. Its
// target keeps the rest.
struct SampledPixels {
    const Target& chosen;   // Supersampling::Part::chosen
    glm::dvec2 place{0.0};  // of the sample in its pixel, in texels of the target
    float edge = 1.0f;      // of the square that it represents, pixels
};

// For a pass that executes others again.
struct PassRepeater {
    std::function<void(std::size_t pass, const SampledPixels& sampled)> repeat;
};

// The pass to execute, its plan and the objects that it reads.
struct PassInput {
    const FramePlan& plan;
    const Pass& pass;
    const std::vector<Target*>& targets;  // as plan.targets
    const GpuScene* scene = nullptr;
    const Pose& pose;
    const Pose* flowPose = nullptr;               // at the time of MeasureFlow
    const GpuEnvironment* environment = nullptr;  // if the pass reads the stored map
    GpuTracer* tracer = nullptr;                  // if a program traces rays
    ProcessorTracer* processorTracer = nullptr;   // if rays are recorded or followed
    ProcessorTracer* flowTracer = nullptr;        // of flowPose; null if it equals `pose`
    // Values of light at vertices, and the same as a texture; null without.
    const light::SurfaceLight* surfaceLight = nullptr;
    const gl::BufferTexture* surfaceLightTexture = nullptr;
    std::span<const light::LightValue> movingLight = {};  // see light::lightOfMoving()
    const gl::Framebuffer* recording = nullptr;  // draws into the target and into records of rays
    const SampledPixels* sampled = nullptr;      // null: all pixels, undisplaced
    const PassRepeater* repeater = nullptr;      // of Supersampling
    std::function<bool()> abandoned = {};        // whether the frame is no longer needed

    const Target& target() const { return *targets[pass.target]; }
    const Target& read(TargetId id) const { return *targets[id]; }
};

// Whether the frame is no longer needed: then the pass returns, and no other one is executed.
bool isInterrupted(PassResources& resources, const PassInput& input);

void execute(PassResources& resources, const PassInput& input, const PrefilterMap& work);
void execute(PassResources& resources, const PassInput& input, const PrefilterCube& work);
void execute(PassResources& resources, const PassInput& input, const BlurCube& work);
void execute(PassResources& resources, const PassInput& input, const BuildLevels& work);
void execute(PassResources& resources, const PassInput& input, const DrawScene& work);
void execute(PassResources& resources, const PassInput& input, const DrawGlass& work);
void execute(PassResources& resources, const PassInput& input, const DrawBlended& work);
void execute(PassResources& resources, const PassInput& input, const FollowRays& work);
void execute(PassResources& resources, const PassInput& input, const DrawShadow& work);
void execute(PassResources& resources, const PassInput& input, const DrawShadowTint& work);
void execute(PassResources& resources, const PassInput& input, const DrawBackFaces& work);
void execute(PassResources& resources, const PassInput& input, const DrawChannel& work);
void execute(PassResources& resources, const PassInput& input, const CopyBackdrop& work);
void execute(PassResources& resources, const PassInput& input, const EmitterCoverage& work);
void execute(PassResources& resources, const PassInput& input, const Supersampling& work);
void execute(PassResources& resources, const PassInput& input, const AssembleLens& work);
void execute(PassResources& resources, const PassInput& input, const Twirl& work);
void execute(PassResources& resources, const PassInput& input, const Convolve& work);
void execute(PassResources& resources, const PassInput& input, const GlowBright& work);
void execute(PassResources& resources, const PassInput& input, const GlowDown& work);
void execute(PassResources& resources, const PassInput& input, const GlowUp& work);
void execute(PassResources& resources, const PassInput& input, const Glow& work);
void execute(PassResources& resources, const PassInput& input, const BackgroundAlpha& work);
void execute(PassResources& resources, const PassInput& input, const ToneMapping& work);
void execute(PassResources& resources, const PassInput& input, const EdgeFilter& work);
void execute(PassResources& resources, const PassInput& input, const StraightAlpha& work);
void execute(PassResources& resources, const PassInput& input, const MeasureFlow& work);
void execute(PassResources& resources, const PassInput& input, const MeasureInstances& work);
void execute(PassResources& resources, const PassInput& input, const FollowLayer& work);
void execute(PassResources& resources, const PassInput& input, const CountLayer& work);

// The view of a pass that draws the scene, for drawAll() and the uniform blocks.
struct PassView {
    const View& view;
    std::span<const ReflectedPicture> reflections = {};
    TargetId environment = kNoTarget;  // the prefiltered map that lights the draws
    TargetId backdrop = kNoTarget;
    OwnBackground background = {};
};

// Fills and binds the uniform block of the view; eye space is rotated by `axesFromWorld` (see
// blocks.glsl).
void bindView(PassResources& resources, const PassInput& input, const PassView& view,
              const glm::dmat3& axesFromWorld);

// Begins a further sample of a view: sets depth to the far end in the chosen pixels and to the near
// end in all others, and colour, if there is one, in the former.
void beginSampledPixels(PassResources& resources, const PassInput& input,
                        const std::optional<glm::vec4>& color);
// Binds what a program with the variant SAMPLED_PIXELS reads.
void bindSampledPixels(PassResources& resources, const PassInput& input);

// Fills the uniform blocks of the pass's reflections; drawAll() binds one for each draw.
void uploadReflections(PassResources& resources, const PassInput& input, const PassView& view,
                       const glm::dmat3& axesFromWorld);
// Binds the map that lights the pass, for draws without a reflected picture.
void bindEnvironment(PassResources& resources, const PassInput& input, TargetId environment);

// Binds one sampler state in every slot; see settle_samplers.frag. Shades no pixel, for any current
// OpenGL state and vertex array.
void settleSamplers(PassResources& resources);

// Draws in order, with the records that begin at `firstRecord` and programs of one kind.
struct DrawProgram {
    const char* vertex;
    const char* fragment;
    Features relevant = ~Features{0};  // features that this kind of program supports
    int variant = 0;
    bool materials = true;   // binds materials; programs depend on VIEW bits (features.glsl)
    bool backFaces = false;  // draws only what is otherwise culled
    bool recordsRays = false;
};
void drawAll(PassResources& resources, const PassInput& input, const PassView& view,
             std::span<const Draw> draws, std::uint32_t firstRecord, const DrawProgram& program);

// The program of `program`'s kind for a draw with `features`. bits: of viewBits(); 0 without
// materials.
ProgramKey keyOf(const FramePlan& plan, const DrawProgram& program, Features features,
                 std::uint32_t bits);
// For drivers that compile in threads of their own: begins all programs that shade surfaces in the
// passes of the plan.
void beginPrograms(PassResources& resources, const PassInput& input);

}  // namespace clerestory
