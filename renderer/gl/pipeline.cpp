#include "gl/pipeline.h"

#include "gl/api.h"
#include "gl/context.h"

#include <array>
#include <cstddef>
#include <stdexcept>
#include <vector>

namespace clerestory::gl {
namespace {

Name begunShader(GLenum stage, const std::string& source) {
    const GLuint shader = glCreateShader(stage);
    const char* text = source.c_str();
    glShaderSource(shader, 1, &text, nullptr);
    glCompileShader(shader);
    return shader;
}

void throwUnlessCompiled(Name shader, const std::string& name) {
    GLint ok = 0, length = 0;
    glGetShaderiv(shader, GL_COMPILE_STATUS, &ok);
    if (ok) return;
    glGetShaderiv(shader, GL_INFO_LOG_LENGTH, &length);
    std::string log(static_cast<std::size_t>(length), ' ');
    glGetShaderInfoLog(shader, length, nullptr, log.data());
    throw std::runtime_error("shader " + name + " does not compile: " + log);
}

Name begunProgram(const ProgramDescription& d) {
    const GLuint program = glCreateProgram();
    const Name fragment = begunShader(GL_FRAGMENT_SHADER, d.fragmentSource);
    for (const Name shader : {d.vertex.name(), fragment}) glAttachShader(program, shader);
    glDeleteShader(fragment);  // when it is detached
    glLinkProgram(program);
    return program;
}

bool isLinked(Name program) {
    GLint ok = 0;
    glGetProgramiv(program, GL_LINK_STATUS, &ok);
    return ok != 0;
}

void replaceByBinary(GLuint program) {
    GLint size = 0;
    glGetProgramiv(program, GL_PROGRAM_BINARY_LENGTH, &size);
    if (size <= 0) return;  // the driver has no cache, and no binaries
    std::vector<std::byte> binary(static_cast<std::size_t>(size));
    GLenum format = 0;
    glGetProgramBinary(program, size, &size, &format, binary.data());
    glProgramBinary(program, format, binary.data(), size);
}

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

VertexShader::VertexShader(const std::string& name, const std::string& source)
    : name_(begunShader(GL_VERTEX_SHADER, source)) {
    throwUnlessCompiled(name_.get(), name);
}

VertexShader::~VertexShader() {
    glDeleteShader(name_.get());
}

Program::Program(const ProgramDescription& description)
    : label_(description.name),
      loadBinary_(description.loadBinary),
      name_(Context::current().firstUse().compile([&] { return begunProgram(description); })) {}

void Program::finish() {
    if (finished_) return;
    Context& context = Context::current();
    context.firstUse().compile([&] {
        const Name program = name_.get();
        std::array<GLuint, 2> shaders{};
        glGetAttachedShaders(program, 2, nullptr, shaders.data());
        for (const Name shader : shaders) throwUnlessCompiled(shader, label_);
        const bool replaces = loadBinary_ || context.firstUse().programsAreNew;
        if (isLinked(program) && replaces && context.capabilities().software) {
            replaceByBinary(program);
        }
        if (!isLinked(program)) {
            GLint length = 0;
            glGetProgramiv(program, GL_INFO_LOG_LENGTH, &length);
            std::string log(static_cast<std::size_t>(length), ' ');
            glGetProgramInfoLog(program, length, nullptr, log.data());
            throw std::runtime_error("program " + label_ + " does not link: " + log);
        }
        for (const Name shader : shaders) glDetachShader(program, shader);
        glObjectLabel(GL_PROGRAM, program, static_cast<GLsizei>(label_.size()), label_.data());
    });
    context.firstUse().countProgram();
    ++context.counters().programs;
    finished_ = true;
}

Program::~Program() {
    glDeleteProgram(name_.get());
}

void Program::use() const {
    Context::current().firstUse().setProgram(name_.get());
    glUseProgram(name_.get());
}

void releaseShaderCompiler() {
    glReleaseShaderCompiler();
}

void apply(const State& state) {
    enable(GL_DEPTH_TEST, state.depthTest != DepthTest::none);
    glDepthFunc(functionOf(state.depthTest));
    glDepthMask(state.depthWrite ? GL_TRUE : GL_FALSE);
    const GLboolean color = state.colorWrite ? GL_TRUE : GL_FALSE;
    glColorMask(color, color, color, color);
    enable(GL_BLEND, state.blending != Blending::none);
    const bool attenuates = state.blending == Blending::attenuate;
    const GLenum behind = attenuates ? GL_SRC_COLOR
                          : state.blending == Blending::add || state.blending == Blending::sum
                              ? GL_ONE
                              : GL_ONE_MINUS_SRC_ALPHA;
    const bool over = state.blending == Blending::over, sum = state.blending == Blending::sum;
    glBlendFuncSeparate(attenuates ? GL_ZERO : GL_ONE, behind,
                        attenuates || over || sum ? GL_ONE : GL_ZERO, over ? behind : GL_ONE);
    glBlendEquationSeparate(GL_FUNC_ADD, attenuates ? GL_MAX : GL_FUNC_ADD);
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
    enable(GL_CULL_FACE, facing.cullBack || facing.cullFront);
    glCullFace(facing.cullFront ? GL_FRONT : GL_BACK);
    glFrontFace(facing.clockwiseIsFront ? GL_CW : GL_CCW);
}

namespace {
void scissor(const Rect& part) {
    glEnable(GL_SCISSOR_TEST);
    glScissor(static_cast<int>(part.x), static_cast<int>(part.y), static_cast<int>(part.width),
              static_cast<int>(part.height));
}
}  // namespace

void clearColorAndDepth(const float (&rgba)[4]) {
    glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    glClearBufferfv(GL_COLOR, 0, rgba);
    clearDepth();
}

void clearDepth() {
    const float farEnd = 0.0f;
    glDepthMask(GL_TRUE);
    glClearBufferfv(GL_DEPTH, 0, &farEnd);
}

void clearDepth(const Rect& part) {
    scissor(part);
    clearDepth();
    glDisable(GL_SCISSOR_TEST);
}

void clearColor(const Rect& part, const float (&rgba)[4]) {
    scissor(part);
    glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    glClearBufferfv(GL_COLOR, 0, rgba);
    glDisable(GL_SCISSOR_TEST);
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
