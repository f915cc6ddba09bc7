// How each type of pass is carried out. A pass applies its state whole, trusts nothing that an
// earlier one left, and reads only the plan: never the request.
#pragma once

#include "passes/draw_stream.h"
#include "passes/gpu_environment.h"
#include "passes/gpu_scene.h"
#include "passes/gpu_tracer.h"
#include "passes/shader_library.h"
#include "passes/targets.h"

namespace clerestory {

struct DrawCounters {
    std::uint64_t drawCalls = 0, triangles = 0;  // of the scene; full-screen triangles not counted
    std::uint64_t meshesMoved = 0;               // see GpuScene::follow()
};

// What passes share from frame to frame.
struct PassResources {
    PassResources();

    ShaderLibrary shaders;
    SamplerCache samplers;
    DrawStream draws;
    MaterialBlocks frameMaterials;
    gl::Buffer viewBlock, reflectionBlock, prefilterBlock, filterBlock;
    gl::VertexArray noVertices;
    gl::Texture environmentBrdf;
    gl::Texture darkness;  // a black cube, where a plan asks for no environment
    DrawCounters counters;
};

// What a pass is about.
struct PassInput {
    const FramePlan& plan;
    const Pass& pass;
    const std::vector<Target*>& targets;  // as plan.targets
    const GpuScene* scene = nullptr;
    const Pose& pose;
    const GpuEnvironment* environment = nullptr;  // where the pass needs the map itself
    GpuTracer* tracer = nullptr;                  // where some draw follows rays

    const Target& target() const { return *targets[pass.target]; }
    const Target& read(TargetId id) const { return *targets[id]; }
};

void execute(PassResources& resources, const PassInput& input, const PrefilterMap& work);
void execute(PassResources& resources, const PassInput& input, const PrefilterCube& work);
void execute(PassResources& resources, const PassInput& input, const BlurCube& work);
void execute(PassResources& resources, const PassInput& input, const BuildLevels& work);
void execute(PassResources& resources, const PassInput& input, const DrawScene& work);
void execute(PassResources& resources, const PassInput& input, const DrawGlass& work);
void execute(PassResources& resources, const PassInput& input, const DrawBackFaces& work);
void execute(PassResources& resources, const PassInput& input, const DrawChannel& work);
void execute(PassResources& resources, const PassInput& input, const CopyBackdrop& work);
void execute(PassResources& resources, const PassInput& input, const Twirl& work);
void execute(PassResources& resources, const PassInput& input, const Convolve& work);
void execute(PassResources& resources, const PassInput& input, const GlowBright& work);
void execute(PassResources& resources, const PassInput& input, const GlowDown& work);
void execute(PassResources& resources, const PassInput& input, const GlowUp& work);
void execute(PassResources& resources, const PassInput& input, const Glow& work);
void execute(PassResources& resources, const PassInput& input, const ToneMapping& work);
void execute(PassResources& resources, const PassInput& input, const EdgeFilter& work);

// How a pass sees the scene: what drawAll() and the blocks need.
struct PassView {
    const View& view;
    std::span<const ReflectedPicture> reflections = {};
    TargetId environment = kNoTarget;  // the prefiltered map that lights the draws
    TargetId backdrop = kNoTarget;
};

// Fills and binds the view's block, eye space turned by `axesFromWorld` (see blocks.glsl).
void bindView(PassResources& resources, const PassInput& input, const PassView& view,
              const glm::dmat3& axesFromWorld);

// Fills the blocks of the pass's reflections, which drawAll() binds draw by draw.
void uploadReflections(PassResources& resources, const PassInput& input, const PassView& view,
                       const glm::dmat3& axesFromWorld);
// The map that lights the pass, for draws that have no reflection of their own.
void bindEnvironment(PassResources& resources, const PassInput& input, TargetId environment);

// Draws in order from the records that begin at `firstRecord`, with programs of one kind.
struct DrawProgram {
    const char* vertex;
    const char* fragment;
    Features relevant = ~0u;  // features that this kind of program knows
    int variant = 0;
    bool materials = true;   // binds them; programs are made for VIEW bits (features.glsl)
    bool backFaces = false;  // draws what is otherwise culled, and nothing else
};
// Gives every sampler slot one state; see settle_samplers.frag. Shades no pixel, whatever the state
// and the vertex array at hand.
void settleSamplers(PassResources& resources);
void drawAll(PassResources& resources, const PassInput& input, const PassView& view,
             std::span<const Draw> draws, std::uint32_t firstRecord, const DrawProgram& program);

}  // namespace clerestory
