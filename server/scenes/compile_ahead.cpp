#include "server/scenes/compile_ahead.h"

#include "server/base/log.h"
#include "server/scenes/shader_cache.h"

#include <algorithm>
#include <bit>
#include <cstdlib>

namespace clerestory {
namespace {

// A small picture for which the driver compiles the same code: of the same format, with edges that
// are powers of two or not, with or without levels.
void makeSmall(TextureImage& image) {
    const auto small = [](std::uint32_t edge) {
        return std::has_single_bit(edge) ? std::min(edge, 4u) : 6u;
    };
    image.width = small(image.width);
    image.height = small(image.height);
    const auto most =
        static_cast<std::uint32_t>(std::bit_width(std::max(image.width, image.height)));
    image.levels = std::min(image.levels, most);
    std::size_t texels = 0;
    for (std::uint32_t level = 0; level < image.levels; ++level) {
        texels +=
            std::size_t{std::max(1u, image.width >> level)} * std::max(1u, image.height >> level);
    }
    image.texels.assign(4 * texels, 255);
}

}  // namespace

Scene copyWithoutTexels(Scene& scene) {
    std::vector<std::vector<std::uint8_t>> texels;
    for (TextureImage& image : scene.images) texels.push_back(std::move(image.texels));
    Scene copy = scene;
    for (std::size_t i = 0; i < texels.size(); ++i) scene.images[i].texels = std::move(texels[i]);
    return copy;
}

bool CompileAhead::helps(const RendererIdentity& identity) {
    return identity.software && std::thread::hardware_concurrency() > 1 && keepsShaders();
}

CompileAhead::CompileAhead(const RendererOptions& options, Scene scene,
                           std::vector<std::shared_ptr<const EnvironmentMap>> maps,
                           std::vector<FrameRequest> frames, std::function<bool()> proceed)
    : thread_([this, options, scene = std::move(scene), maps = std::move(maps),
               frames = std::move(frames), proceed = std::move(proceed)]() mutable {
          run(options, std::move(scene), maps, frames, proceed);
          ended_ = true;
      }) {}

CompileAhead::~CompileAhead() {
    stop();
    thread_.join();
}

// Failures are harmless: the renderer compiles everything itself.
void CompileAhead::run(RendererOptions options, Scene scene,
                       const std::vector<std::shared_ptr<const EnvironmentMap>>& maps,
                       const std::vector<FrameRequest>& frames,
                       const std::function<bool()>& proceed) {
    try {
        options.onReset = nullptr;
        options.onCompiling = nullptr;
        Renderer renderer(options);
        for (const auto& map : maps) renderer.addEnvironment(map);
        for (TextureImage& image : scene.images) makeSmall(image);
        const std::string id = scene.id;
        renderer.addScene(std::move(scene));
        renderer.expectCompilation(id, true);
        WarmUp warmUp = renderer.beginWarmUp(frames);
        while (!stopping_ && proceed() && renderer.advance(warmUp, true)) {
        }
    } catch (const std::exception& error) {
        logDebug({"compiling ahead: ", error.what()});
    }
}

}  // namespace clerestory
