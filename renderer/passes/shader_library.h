// Shader programs by source files and features; compiled on first use.
#pragma once

#include "gl/pipeline.h"
#include "plan/graph/frame_plan.h"

#include <compare>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>

namespace clerestory {

struct ProgramKey {
    std::string vertex, fragment;  // names of files in shaders/
    // Of the fragment shader. All programs with one vertex shader share it, so that the driver
    // compiles it once for each set of outputs that is read; VIEW_SURFACE_LIGHT alone makes
    // another.
    Features features = 0;        // FEATURES and LAYERS in the source
    int variant = 0;              // VARIANT in the source
    std::uint32_t view = 0;       // VIEW in the source: what holds for every pixel of a pass
    bool recordsRays = false;     // RECORDS_RAYS in the source: rays become records
    std::uint32_t hitLayers = 0;  // HIT_LAYERS in the source
    auto operator<=>(const ProgramKey&) const = default;
};

// Whether its shader follows rays, in place of recording them.
bool tracesRays(const ProgramKey& key);

// The programs that renderers of this process are compiling. A renderer waits for another one that
// compiles the same program, because it then finds the result in the driver's cache; two at the
// same time would both compile it.
class CompilingProgram {
public:
    CompilingProgram() = default;
    CompilingProgram(const CompilingProgram&) = delete;
    ~CompilingProgram() { end(); }
    // Ends the previous one. Waits while another renderer compiles `key`, for 2 s at most.
    void begin(const ProgramKey& key);
    void end();

private:
    std::optional<ProgramKey> key_;
};

class ShaderLibrary {
public:
    // A program that is new counts as being compiled until the next call or the end of the pass,
    // since a driver may compile it when it is first drawn with. Throws std::runtime_error when the
    // driver does not compile it.
    const gl::Program& program(const ProgramKey& key);
    bool holds(const ProgramKey& key) const { return programs_.contains(key); }
    // Has the driver compile it in a thread of its own, if it can, until program() waits for it.
    void begin(const ProgramKey& key);
    void endPass() { compiling_.end(); }

private:
    gl::Program made(const ProgramKey& key);
    const gl::VertexShader& vertexShader(const std::string& file, std::uint32_t view);

    std::map<std::pair<std::string, std::uint32_t>, gl::VertexShader> vertexShaders_;
    std::map<ProgramKey, gl::Program> programs_;
    CompilingProgram compiling_;
};

// Returns a shader file with its includes expanded. Throws std::runtime_error for an unknown file.
std::string shaderSource(const std::string& file, Features features, int variant,
                         std::uint32_t view = 0, bool recordsRays = false,
                         std::uint32_t hitLayers = 0);
// The same for a source text.
std::string withIncludes(const std::string& text, Features features, int variant,
                         std::uint32_t view = 0, bool recordsRays = false,
                         std::uint32_t hitLayers = 0);

}  // namespace clerestory
