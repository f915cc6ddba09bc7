// Assembles sources. Each file is included once; #line directives keep the positions in compiler
// messages correct.
#include "passes/shader_library.h"

#include "embedded_embeddedShaders.h"
#include "plan/graph/features.h"
#include "shaders/include/bindings.glsl"

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <set>
#include <sstream>
#include <stdexcept>

namespace clerestory {
namespace {

constexpr Features kFeaturesOfRays = FEATURE_TRACED_REFLECTION | FEATURE_TRACED_GLASS;
constexpr Features kFeaturesOfGlass = FEATURE_GLASS | FEATURE_TRACED_GLASS;

struct LayerMap {
    std::uint32_t layer;
    int unit;
    const char* sampler;
};

constexpr LayerMap kLayerMaps[] = {
    {LAYER_SPECULAR_MAP, UNIT_SPECULAR, "specularMap"},
    {LAYER_SPECULAR_COLOR_MAP, UNIT_SPECULAR_COLOR, "specularColorMap"},
    {LAYER_CLEARCOAT_MAP, UNIT_CLEARCOAT, "clearcoatMap"},
    {LAYER_CLEARCOAT_ROUGHNESS_MAP, UNIT_CLEARCOAT_ROUGHNESS, "clearcoatRoughnessMap"},
    {LAYER_CLEARCOAT_NORMAL_MAP, UNIT_CLEARCOAT_NORMAL, "clearcoatNormalMap"},
    {LAYER_SHEEN_COLOR_MAP, UNIT_SHEEN_COLOR, "sheenColorMap"},
    {LAYER_SHEEN_ROUGHNESS_MAP, UNIT_SHEEN_ROUGHNESS, "sheenRoughnessMap"},
    {LAYER_IRIDESCENCE_MAP, UNIT_IRIDESCENCE, "iridescenceMap"},
    {LAYER_IRIDESCENCE_THICKNESS_MAP, UNIT_IRIDESCENCE_THICKNESS, "iridescenceThicknessMap"},
    {LAYER_ANISOTROPY_MAP, UNIT_ANISOTROPY, "anisotropyMap"},
    {LAYER_DIFFUSE_TRANSMISSION_MAP, UNIT_DIFFUSE_TRANSMISSION, "diffuseTransmissionMap"},
    {LAYER_DIFFUSE_TRANSMISSION_COLOR_MAP, UNIT_DIFFUSE_TRANSMISSION_COLOR,
     "diffuseTransmissionColorMap"},
};

// Drivers count samplers that are declared, used or not. Code that is not selected names another.
void declareLayerMaps(std::uint32_t layers, std::ostringstream& out) {
    for (const LayerMap& map : kLayerMaps) {
        if ((layers & map.layer) != 0) {
            out << "layout(binding = " << map.unit << ") uniform sampler2D " << map.sampler
                << ";\n";
        } else {
            out << "#define " << map.sampler << " baseColorMap\n";
        }
    }
}

std::string_view embedded(const std::string& file) {
    for (const EmbeddedFile& f : embeddedShaders()) {
        if (f.name == file) return f.content;
    }
    throw std::runtime_error("no shader file is called " + file);
}

void append(const std::string& text, std::set<std::string>& seen, std::ostringstream& out) {
    const auto number = seen.size();
    out << "#line 1 " << number << "\n";
    std::istringstream lines{text};
    std::string line;
    const std::string directive = "#include \"";
    for (int n = 1; std::getline(lines, line); ++n) {
        if (!line.starts_with(directive)) {
            out << line << "\n";
            continue;
        }
        const std::string file = line.substr(directive.size(), line.rfind('"') - directive.size());
        if (seen.insert(file).second) append(std::string(embedded(file)), seen, out);
        out << "#line " << n + 1 << " " << number << "\n";
    }
}

std::mutex compilingMutex;
std::condition_variable compilingEnded;
std::multiset<ProgramKey> compiling;  // guarded by compilingMutex

}  // namespace

bool tracesRays(const ProgramKey& key) {
    return (key.features & kFeaturesOfRays) != 0 && !key.recordsRays;
}

void CompilingProgram::begin(const ProgramKey& key) {
    end();
    std::unique_lock lock(compilingMutex);
    compilingEnded.wait_for(lock, std::chrono::seconds(2),
                            [&] { return !compiling.contains(key); });
    compiling.insert(key);
    key_ = key;
}

void CompilingProgram::end() {
    if (!key_) return;
    const std::lock_guard lock(compilingMutex);
    compiling.erase(compiling.find(*key_));
    key_.reset();
    compilingEnded.notify_all();
}

std::string withIncludes(const std::string& text, Features features, int variant,
                         std::uint32_t view, bool recordsRays, std::uint32_t hitLayers) {
    const auto layers = static_cast<std::uint32_t>(features >> 32);
    std::ostringstream out;
    out << "#version 430 core\n"
        << "const uint FEATURES = " << static_cast<std::uint32_t>(features) << "u;\n"
        << "const uint LAYERS = " << layers << "u;\n"
        << "const uint HIT_LAYERS = " << hitLayers << "u;\n"
        << "const uint SHADED_LAYERS = " << (layers | hitLayers) << "u;\n"
        << "const int VARIANT = " << variant << ";\n"
        << "const uint VIEW = " << view << "u;\n"
        << "#define TRACES_RAYS " << ((features & kFeaturesOfRays) != 0) << "\n"
        << "#define RECORDS_RAYS " << recordsRays << "\n"
        << "#define RAYS_OF_PIXEL " << ((features & FEATURE_TRACED_GLASS) != 0 ? 2 : 1) << "\n"
        << "#define HAS_NORMAL_MAP " << ((features & FEATURE_NORMAL_MAP) != 0) << "\n"
        << "#define HAS_LAYERS " << (layers != 0) << "\n"
        << "#define SHADES_GLASS " << ((features & kFeaturesOfGlass) != 0) << "\n";
    if (layers != 0) declareLayerMaps(layers, out);
    std::set<std::string> seen;
    append(text, seen, out);
    return out.str();
}

std::string shaderSource(const std::string& file, Features features, int variant,
                         std::uint32_t view, bool recordsRays, std::uint32_t hitLayers) {
    return withIncludes(std::string(embedded(file)), features, variant, view, recordsRays,
                        hitLayers);
}

const gl::VertexShader& ShaderLibrary::vertexShader(const std::string& file, std::uint32_t view) {
    const auto key = std::pair(file, view & (VIEW_SURFACE_LIGHT | VIEW_EMITTERS));
    const auto found = vertexShaders_.find(key);
    if (found != vertexShaders_.end()) return found->second;
    return vertexShaders_.emplace(key, gl::VertexShader(file, shaderSource(file, 0, 0, key.second)))
        .first->second;
}

gl::Program ShaderLibrary::made(const ProgramKey& key) {
    return gl::Program({.name = key.fragment + " features " + std::to_string(key.features) +
                                " variant " + std::to_string(key.variant) + " view " +
                                std::to_string(key.view),
                        .vertex = vertexShader(key.vertex, key.view),
                        .fragmentSource = shaderSource(key.fragment, key.features, key.variant,
                                                       key.view, key.recordsRays, key.hitLayers),
                        .loadBinary = tracesRays(key)});
}

void ShaderLibrary::begin(const ProgramKey& key) {
    if (!holds(key)) programs_.emplace(key, made(key));
}

const gl::Program& ShaderLibrary::program(const ProgramKey& key) {
    auto found = programs_.find(key);
    if (found != programs_.end() && found->second.finished()) {
        compiling_.end();
        return found->second;
    }
    compiling_.begin(key);
    if (found == programs_.end()) found = programs_.emplace(key, made(key)).first;
    try {
        found->second.finish();
    } catch (...) {
        programs_.erase(found);
        throw;
    }
    return found->second;
}

}  // namespace clerestory
