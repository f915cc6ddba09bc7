// Applying state.
#include "gl/state.h"

#include "gl/api.h"
#include "gl/context.h"

namespace clerestory::gl {
namespace {

void enable(GLenum what, bool on) {
    if (on)
        glEnable(what);
    else
        glDisable(what);
}

GLenum functionOf(DepthTest test) {
    switch (test) {
        case DepthTest::none:
            return GL_ALWAYS;
        case DepthTest::nearer:
            return GL_GREATER;
        case DepthTest::nearerOrEqual:
            return GL_GEQUAL;
        case DepthTest::equal:
            return GL_EQUAL;
    }
    return GL_ALWAYS;
}

}  // namespace

void apply(const State& state) {
    enable(GL_DEPTH_TEST, state.depthTest != DepthTest::none);
    glDepthFunc(functionOf(state.depthTest));
    glDepthMask(state.depthWrite ? GL_TRUE : GL_FALSE);
    const GLboolean color = state.colorWrite ? GL_TRUE : GL_FALSE;
    glColorMask(color, color, color, color);
    enable(GL_BLEND, state.blending != Blending::none);
    glBlendFuncSeparate(GL_ONE, GL_ONE_MINUS_SRC_ALPHA, GL_ZERO, GL_ONE);
    enable(GL_CLIP_DISTANCE0, state.clip);
    glEnable(GL_TEXTURE_CUBE_MAP_SEAMLESS);
    glEnable(GL_FRAMEBUFFER_SRGB);
    glDisable(GL_SCISSOR_TEST);
    if (Context::current().capabilities().clipControl) {
        glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
    }
    Context::current().firstUse().setState(static_cast<std::uint32_t>(state.depthTest) |
                                           static_cast<std::uint32_t>(state.blending) << 4 |
                                           state.depthWrite << 8 | state.colorWrite << 9 |
                                           state.clip << 10);
}

void apply(const Facing& facing) {
    enable(GL_CULL_FACE, facing.cullBack);
    glCullFace(GL_BACK);
    glFrontFace(facing.clockwiseIsFront ? GL_CW : GL_CCW);
}

void clearColorAndDepth() {
    const float black[4] = {0.0f, 0.0f, 0.0f, 0.0f};
    glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    glClearBufferfv(GL_COLOR, 0, black);
    clearDepth();
}

void clearDepth() {
    const float farEnd = 0.0f;
    glDepthMask(GL_TRUE);
    glClearBufferfv(GL_DEPTH, 0, &farEnd);
}

glm::dmat4 deviceClip(const glm::dmat4& clip, bool clipControl) {
    if (clipControl) return clip;
    glm::dmat4 deviceFromClip(1.0);  // z' = 2 z - w, so that (z'/w + 1) / 2 = z / w
    deviceFromClip[2][2] = 2.0;
    deviceFromClip[3][2] = -1.0;
    return deviceFromClip * clip;
}

DebugGroup::DebugGroup(const std::string& name) {
    glPushDebugGroup(GL_DEBUG_SOURCE_APPLICATION, 0, static_cast<GLsizei>(name.size()),
                     name.data());
}

DebugGroup::~DebugGroup() {
    glPopDebugGroup();
}

}  // namespace clerestory::gl
