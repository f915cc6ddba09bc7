// Detects the capabilities of the driver and collects its messages.
#include "gl/context.h"

#include "gl/api.h"

#include <EGL/egl.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <chrono>
#include <cmath>
#include <stdexcept>

namespace clerestory::gl {
namespace {

thread_local Context* currentContext = nullptr;

std::string text(GLenum name) {
    const GLubyte* value = glGetString(name);
    return value ? reinterpret_cast<const char*>(value) : "";
}

int integer(GLenum name) {
    GLint value = 0;
    glGetIntegerv(name, &value);
    return value;
}

bool hasExtension(const std::string& wanted) {
    const int count = integer(GL_NUM_EXTENSIONS);
    for (int i = 0; i < count; ++i) {
        const GLubyte* name = glGetStringi(GL_EXTENSIONS, static_cast<GLuint>(i));
        if (wanted == reinterpret_cast<const char*>(name)) return true;
    }
    return false;
}

// Whether the driver compiles in threads of its own; then it may use as many as it likes.
bool allowCompilerThreads() {
    for (const char* vendor : {"KHR", "ARB"}) {
        if (!hasExtension(std::string("GL_") + vendor + "_parallel_shader_compile")) continue;
        const auto setThreads = reinterpret_cast<void (*)(GLuint)>(
            eglGetProcAddress((std::string("glMaxShaderCompilerThreads") + vendor).c_str()));
        if (!setThreads) continue;
        setThreads(~0u);
        return true;
    }
    return false;
}

// Compares the driver's clock with ours over some work.
bool timestampsAgreeWithWallClock() {
    using Clock = std::chrono::steady_clock;
    constexpr double kMinNanoseconds = 2e6;  // long against the clocks' steps
    std::array<GLuint, 2> queries{};
    GLuint buffer = 0;
    const std::vector<char> bytes(1 << 20);
    glGenQueries(2, queries.data());
    glGenBuffers(1, &buffer);
    glBindBuffer(GL_COPY_WRITE_BUFFER, buffer);
    glFinish();
    glQueryCounter(queries[0], GL_TIMESTAMP);
    const auto start = Clock::now();
    double wall = 0.0;
    while (wall < kMinNanoseconds) {
        glBufferData(GL_COPY_WRITE_BUFFER, static_cast<GLsizeiptr>(bytes.size()), bytes.data(),
                     GL_STREAM_DRAW);
        glFinish();
        wall = std::chrono::duration<double, std::nano>(Clock::now() - start).count();
    }
    glQueryCounter(queries[1], GL_TIMESTAMP);
    glFinish();
    std::array<GLuint64, 2> stamps{};
    for (std::size_t i = 0; i < 2; ++i) {
        glGetQueryObjectui64v(queries[i], GL_QUERY_RESULT, &stamps[i]);
    }
    glDeleteQueries(2, queries.data());
    glDeleteBuffers(1, &buffer);
    const double driver = stamps[1] > stamps[0] ? static_cast<double>(stamps[1] - stamps[0]) : 0.0;
    return std::abs(driver - wall) < 0.2 * wall;
}

void APIENTRY onMessage(GLenum source, GLenum type, GLuint id, GLenum severity, GLsizei length,
                        const GLchar* message, const void* user) {
    (void)source;
    // Hints about speed name no mistake, for example that a state requires another compilation.
    if (severity == GL_DEBUG_SEVERITY_NOTIFICATION || type == GL_DEBUG_TYPE_PERFORMANCE) return;
    auto* context = static_cast<Context*>(const_cast<void*>(user));
    context->addMessage(std::to_string(id) + ": " +
                        std::string(message, static_cast<std::size_t>(std::max(0, length))));
}

std::int64_t nanoseconds() {
    return std::chrono::duration_cast<std::chrono::nanoseconds>(
               std::chrono::steady_clock::now().time_since_epoch())
        .count();
}

}  // namespace

Context::Context(const ContextOptions& options) {
    const OpenedContext opened = openContext(options);
    display_ = opened.display;
    context_ = opened.context;
    surface_ = opened.surface;
    currentContext = this;
    findCapabilities(opened.platform);
    capabilities_.device = options.device;
    if (options.debugOutput) {
        glEnable(GL_DEBUG_OUTPUT);
        glEnable(GL_DEBUG_OUTPUT_SYNCHRONOUS);
        glDebugMessageCallback(onMessage, this);
    }
}

Context::~Context() {
    assert(std::this_thread::get_id() == owner_);
    if (currentContext == this) currentContext = nullptr;
    closeContext({display_, context_, surface_, {}});
}

void Context::makeCurrent() {
    assert(std::this_thread::get_id() == owner_);
    currentContext = this;
    if (eglGetCurrentContext() != context_ &&
        !eglMakeCurrent(display_, surface_, surface_, context_)) {
        throw std::runtime_error("the OpenGL context could not be made current");
    }
}

Context& Context::current() {
    assert(currentContext != nullptr);
    return *currentContext;
}

void Context::addMessage(std::string message) {
    constexpr std::size_t kMax = 100;  // a message a draw would fill memory
    if (messages_.size() < kMax) messages_.push_back(std::move(message));
}

void Context::throwIfFailed() {
    const GLenum error = glGetError();
    if (error == GL_NO_ERROR) return;
    if (error == GL_OUT_OF_MEMORY) throw std::runtime_error("the driver has no memory left");
    throw std::runtime_error("the driver refused a call (error " + std::to_string(error) + ")");
}

bool Context::lost() const {
    return resetStatus_ && resetStatus_() != GL_NO_ERROR;
}

void Context::discardErrors() {
    constexpr int kMax = 100;  // a lost context answers with errors for ever
    for (int i = 0; i < kMax && glGetError() != GL_NO_ERROR; ++i) {
    }
    // Closes groups that the failure left open. The stack has a group of its own.
    const int depth = std::min(kMax, integer(GL_DEBUG_GROUP_STACK_DEPTH));
    for (int i = 1; i < depth; ++i) glPopDebugGroup();
}

void Context::findCapabilities(const std::string& platform) {
    Capabilities& c = capabilities_;
    c.vendor = text(GL_VENDOR);
    c.renderer = text(GL_RENDERER);
    c.version = text(GL_VERSION);
    c.shadingLanguage = text(GL_SHADING_LANGUAGE_VERSION);
    c.platform = platform;
    c.software = isSoftwareRenderer(c.renderer);
    c.clipControl = hasExtension("GL_ARB_clip_control") ||
                    integer(GL_MAJOR_VERSION) * 10 + integer(GL_MINOR_VERSION) >= 45;
    // A software driver stamps work when it is queued, not when it is done (0.2 ms for 80 ms).
    c.timerQueriesTrusted = !c.software && timestampsAgreeWithWallClock();
    const bool inCore = integer(GL_MAJOR_VERSION) * 10 + integer(GL_MINOR_VERSION) >= 45;
    if (inCore || hasExtension("GL_KHR_robustness")) {
        resetStatus_ = &glGetGraphicsResetStatus;
    } else if (hasExtension("GL_ARB_robustness")) {
        resetStatus_ =
            reinterpret_cast<unsigned (*)()>(eglGetProcAddress("glGetGraphicsResetStatusARB"));
    }
    // A graphics card would read such buffers over the bus, at each draw.
    c.readsClientMemory = c.software && hasExtension("GL_AMD_pinned_memory");
    // Mesa's rasteriser compiles when a program is first drawn with.
    c.compilesInThreads = !c.software && allowCompilerThreads();
    // The context may not have the requested reset notification.
    c.tellsOfResets = resetStatus_ && integer(GL_RESET_NOTIFICATION_STRATEGY) ==
                                          static_cast<int>(GL_LOSE_CONTEXT_ON_RESET);
    if (!c.tellsOfResets) resetStatus_ = nullptr;
    glGetError();  // the number above is not known to every driver
    c.maxTextureSize = static_cast<std::uint32_t>(integer(GL_MAX_TEXTURE_SIZE));
    c.uniformAlignment =
        static_cast<std::uint32_t>(std::max(16, integer(GL_UNIFORM_BUFFER_OFFSET_ALIGNMENT)));
    if (hasExtension("GL_EXT_texture_filter_anisotropic") ||
        hasExtension("GL_ARB_texture_filter_anisotropic")) {
        constexpr GLenum kMaxTextureMaxAnisotropy = 0x84FF;
        c.maxAnisotropy =
            static_cast<std::uint32_t>(std::max(1, integer(kMaxTextureMaxAnisotropy)));
    }
}

FirstUse::Timed::Timed(FirstUse& use) : use_(use), begin_(nanoseconds()) {
    if (use_.whenCompiling) use_.whenCompiling(true);
}

FirstUse::Timed::~Timed() {
    use_.counters_.milliseconds += 1e-6 * static_cast<double>(nanoseconds() - begin_);
    if (use_.whenCompiling) use_.whenCompiling(false);
}

}  // namespace clerestory::gl
