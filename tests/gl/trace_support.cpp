// See trace_support.h.
#include "trace_support.h"

#include "gl/api.h"
#include "gl/pipeline.h"
#include "passes/shader_library.h"

#include <algorithm>
#include <chrono>

namespace clerestory::test {
namespace {

// The values that channel.frag writes for the hit of the ray through the pixel.
constexpr const char* kTracedChannel = R"(
#include "include/block_macros.glsl"
#include "include/features.glsl"
#include "include/trace.glsl"
float iorOfPath(float ior, float dispersion) {
    return ior;
}
#include "include/hit.glsl"
in vec3 towards;
out vec4 number;

void main() {
    vec3 along = normalize(towards);
    Hit hit = traceClosest(tracing.eye.xyz, worldAxes(along), 0.0f, 1e30f);
    bool met = hit.triangle >= 0;
    number = vec4(0.0f);
    if (CHANNEL == CHANNEL_DEPTH) number.x = met ? dot(view.forward.xyz, along) * hit.distance : 0.0f;
    if (CHANNEL == CHANNEL_NORMAL) {
        HitPoint p = hitPoint(hit, along, 0.0f);
        number.xyz = met ? p.material.normal : vec3(0.0f);
    }
    if (CHANNEL == CHANNEL_NUMBER) {
        int triangle = TRACE_TRIANGLE_ROWS * max(hit.triangle, 0);
        number.x = met ? texelFetch(traceTriangles, triangle + 1).w + 1.0f : 0.0f;
    }
}
)";

int numberOf(Channel channel) {
    return channel == Channel::normal     ? CHANNEL_NORMAL
           : channel == Channel::objectId ? CHANNEL_NUMBER
                                          : CHANNEL_DEPTH;
}

}  // namespace

bool tracesAnything(const FramePlan& plan) {
    return std::any_of(plan.passes.begin(), plan.passes.end(),
                       [](const Pass& pass) { return followsRays(pass); });
}

PlanRunner& workbench() {
    static PlanRunner instance;
    return instance;
}

PlanRunner::PlanRunner()
    : context_({.driver = gl::Driver::automatic, .debugOutput = true}),
      environment_(*builtinEnvironment("sky")) {}

void PlanRunner::show(Scene scene) {
    context_.makeCurrent();
    tracer_.reset();
    gpuScene_.reset();
    if (scene_) executor_.forget(*scene_);
    if (auto map = builtinEnvironment(scene.environment)) environment_ = std::move(*map);
    scene_ = std::make_shared<Scene>(std::move(scene));
    pose_ = poseAt(*scene_, 0.0);
    executor_.upload(scene_);
    gpuScene_ = std::make_unique<GpuScene>(scene_, resources_.draws.records());
}

FramePlan PlanRunner::plan(const FrameRequest& request) const {
    return planFrame({.scene = *scene_,
                      .pose = pose_,
                      .environment = environment_,
                      .maps = {},
                      .resident = {},
                      .limits = {.rays = Rays::shader}},
                     request);
}

Image PlanRunner::run(const FramePlan& plan) {
    context_.makeCurrent();
    Execution done = executor_.run({plan, *scene_, pose_, environment_, {}});
    passMilliseconds_ = std::move(done.passMilliseconds);
    return std::move(done.image);
}

Image PlanRunner::traced(const FramePlan& planned, int rounds, double* milliseconds) {
    context_.makeCurrent();
    FramePlan plan = planned;
    if (!plan.rays) {  // a plan of numbers has none: its rays need no light and no glass
        plan.rays.emplace();
        plan.rays->instances.resize(scene_->instances.size());
        plan.rays->materials.resize(scene_->materials.size() + plan.materials.size());
    }
    if (!tracer_) tracer_ = std::make_unique<GpuTracer>(*gpuScene_);
    const Pass& pass = plan.passes.at(0);
    const View& view = *pass.view();
    Target target(plan.targets.at(pass.target));
    std::vector<Target*> targets{&target};
    const PassInput input{
        .plan = plan, .pass = pass, .targets = targets, .scene = gpuScene_.get(), .pose = pose_};
    tracer_->prepare(plan, pose_);
    resources_.draws.begin(*scene_, pose_, view, glm::dmat3(1.0), plan.lights);
    tracer_->addInstances(resources_.draws);
    resources_.draws.upload();
    bindView(resources_, input, {.view = view}, glm::dmat3(1.0));
    tracer_->bind(plan, view.eye);
    const gl::VertexShader vertex("sky.vert", shaderSource("sky.vert", 0, 0));
    gl::Program program(
        {.name = "traced channel",
         .vertex = vertex,
         .fragmentSource = withIncludes(
             "const int CHANNEL = " + std::to_string(numberOf(plan.channel)) + ";" + kTracedChannel,
             0, static_cast<int>(plan.rays->hitFeatures))});
    program.finish();
    target.drawn().bind();
    gl::apply(gl::State{});
    gl::apply(gl::Facing{.cullBack = false});
    program.use();
    resources_.noVertices.bind();
    for (int i = 0; i < rounds; ++i) {
        const auto start = std::chrono::steady_clock::now();
        gl::clearColorAndDepth();
        gl::drawTriangle();
        glFinish();
        if (milliseconds) {
            *milliseconds =
                std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
                    .count();
        }
    }
    const std::uint32_t channels = plan.channel == Channel::normal ? 3 : 1;
    std::vector<float> rgba(std::size_t{4} * plan.width * plan.height);
    target.readable().readFloats(rgba);
    Image image = makeImage(plan.width, plan.height, channels, PixelType::float32);
    float* out = image.floats();
    for (std::uint32_t y = plan.height; y-- > 0;) {
        for (std::uint32_t x = 0; x < plan.width; ++x) {
            const float* in = rgba.data() + 4 * (std::size_t{y} * plan.width + x);
            out = std::copy(in, in + channels, out);
        }
    }
    return image;
}

}  // namespace clerestory::test
