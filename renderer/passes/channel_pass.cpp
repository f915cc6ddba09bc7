// The scene from one view as numbers: depth, normals, or a number of each draw.
#include "passes/blocks.h"
#include "passes/passes.h"
#include "plan/graph/features.h"

namespace clerestory {
namespace {

constexpr Features kGeometry = FEATURE_MASK | FEATURE_DOUBLE_SIDED;
constexpr Features kCoverage = FEATURE_BASE_COLOR_MAP | FEATURE_VERTEX_COLOR |
                               FEATURE_TEXTURE_TRANSFORM | FEATURE_SECOND_TEXCOORD;

int variantOf(Channel channel) {
    switch (channel) {
        case Channel::normal:
            return CHANNEL_NORMAL;
        case Channel::objectId:
        case Channel::through:
            return CHANNEL_NUMBER;
        case Channel::depth:
        case Channel::color:
            break;
    }
    return CHANNEL_DEPTH;
}

}  // namespace

void execute(PassResources& resources, const PassInput& input, const DrawChannel& work) {
    const glm::dmat3 worldAxes(1.0);
    const PassView view{.view = work.view};
    resources.draws.begin(input.scene->scene(), input.pose, work.view, worldAxes,
                          input.plan.lights);
    const std::uint32_t records = resources.draws.add(work.draws);
    resources.draws.upload();
    bindView(resources, input, view, worldAxes);

    input.target().drawn().bind();
    gl::apply(gl::State{.depthTest = gl::DepthTest::nearer, .depthWrite = true});
    gl::clearColorAndDepth();
    const DrawProgram program{"surface.vert", "channel.frag", kGeometry | kCoverage,
                              variantOf(input.plan.channel)};
    drawAll(resources, input, view, work.draws, records, program);
    input.target().resolve();
}

}  // namespace clerestory
