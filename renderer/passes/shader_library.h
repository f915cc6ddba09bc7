// Programs by the files they are made of and the features they have; compiled at first use.
#pragma once

#include "gl/program.h"
#include "plan/graph/frame_plan.h"

#include <compare>
#include <map>
#include <string>

namespace clerestory {

struct ProgramKey {
    std::string vertex, fragment;  // names of files in shaders/
    // Of the fragment shader. All programs with one vertex shader share it, so that the driver
    // compiles it once for each set of outputs that is read.
    Features features = 0;   // FEATURES in the source
    int variant = 0;         // VARIANT in the source
    std::uint32_t view = 0;  // VIEW in the source: what holds for every pixel of a pass
    auto operator<=>(const ProgramKey&) const = default;
};

class ShaderLibrary {
public:
    // Throws std::runtime_error when the driver does not compile it.
    const gl::Program& program(const ProgramKey& key);

private:
    const gl::VertexShader& vertexShader(const std::string& file);

    std::map<std::string, gl::VertexShader> vertexShaders_;
    std::map<ProgramKey, gl::Program> programs_;
};

// A shader file with its includes in place. Throws std::runtime_error for a file that is not there.
std::string shaderSource(const std::string& file, Features features, int variant,
                         std::uint32_t view = 0);
// The same for a text that is no file, of which only the includes are.
std::string withIncludes(const std::string& text, Features features, int variant,
                         std::uint32_t view = 0);

}  // namespace clerestory
