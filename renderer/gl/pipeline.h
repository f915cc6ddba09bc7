// What a draw uses besides its buffers: compiled vertex shaders and linked programs; OpenGL's fixed
// state that a pass can set, as one value that is applied whole; and the clip space of this
// renderer.
#pragma once

#include "gl/api.h"
#include "gl/texture.h"

#include <glm/glm.hpp>

#include <string>

namespace clerestory::gl {

class VertexShader {
public:
    // `name` is for error messages. Throws std::runtime_error with the driver's log when it does
    // not compile.
    VertexShader(const std::string& name, const std::string& source);
    VertexShader(VertexShader&&) = default;
    ~VertexShader();
    Name name() const { return name_.get(); }

private:
    OwnedName name_;
};

struct ProgramDescription {
    std::string name;  // for debuggers and error messages
    const VertexShader& vertex;
    std::string fragmentSource;
    // llvmpipe does not find code that it compiled for a program that was linked when the program
    // comes from the driver's cache, in another context or process, and compiles it again. With
    // this, and while FirstUse::programsAreNew, a linked program is replaced by its own binary,
    // which is what the cache holds; that takes as long as to link a program from the cache. For a
    // program with nested loops the code is another one, too. Other drivers ignore it.
    bool loadBinary = false;
};

class Program {
public:
    // Begins to compile. Drivers with Capabilities::compilesInThreads continue while other programs
    // begin; others have compiled it when this returns.
    explicit Program(const ProgramDescription& description);
    Program(Program&&) = default;
    ~Program();
    // Waits for the driver, once, before the first use(). Throws std::runtime_error with the
    // driver's log when the program does not compile or link.
    void finish();
    bool finished() const { return finished_; }
    void use() const;
    Name name() const { return name_.get(); }

private:
    std::string label_;
    bool loadBinary_ = false;
    bool finished_ = false;
    OwnedName name_;
};

// Frees the driver's data for compiling shaders; compiling the next shader allocates it again.
void releaseShaderCompiler();

// Depth is reversed: greater is nearer.
enum class DepthTest { none, nearer, nearerOrEqual, equal };
// attenuate: colour times what was there, and the greater alpha. over: as premultiplied, of alpha
// too.
enum class Blending { none, premultiplied, over, add, sum, attenuate };

struct State {
    DepthTest depthTest = DepthTest::none;
    bool depthWrite = false;
    bool colorWrite = true;
    Blending blending = Blending::none;  // of colour; over, sum and attenuate change alpha, too
    bool clip = false;                   // gl_ClipDistance[0] is enabled
};

// Also sets what never differs: seamless cubes, sRGB encoding into sRGB targets, clip control,
// no scissor. Culling belongs to each draw.
void apply(const State& state);

// What a draw culls: nothing, back faces, which are clockwise unless clockwiseIsFront, or front
// faces.
struct Facing {
    bool cullBack = true;
    bool cullFront = false;  // in place of back faces
    bool clockwiseIsFront = false;
    bool operator==(const Facing&) const = default;
};
void apply(const Facing& facing);

// Colour, by default to black with alpha 0; depth to the far end.
void clearColorAndDepth(const float (&rgba)[4] = {0.0f, 0.0f, 0.0f, 0.0f});
void clearDepth();
// The same in a part of the framebuffer.
void clearDepth(const Rect& part);
void clearColor(const Rect& part, const float (&rgba)[4]);

// The plan's clip space has depth 0..1. Without clip control OpenGL requires -1..1: only this
// function converts.
glm::dmat4 deviceClip(const glm::dmat4& clip, bool clipControl);

// Groups the OpenGL calls of its lifetime in frame debuggers.
class DebugGroup {
public:
    explicit DebugGroup(const std::string& name);
    ~DebugGroup();
    DebugGroup(const DebugGroup&) = delete;
    DebugGroup& operator=(const DebugGroup&) = delete;
};

}  // namespace clerestory::gl
