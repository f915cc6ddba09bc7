// The targets that passes draw into. They are reused from frame to frame: a frame like the previous
// one creates none.
#pragma once

#include "display/display.h"
#include "gl/texture.h"
#include "plan/graph/frame_context.h"
#include "plan/graph/target.h"

#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <vector>

namespace clerestory {

// Of processor storage it is picture(), and nothing else; otherwise the rest.
class Target {
public:
    explicit Target(const TargetSpec& spec);

    const TargetSpec& spec() const { return spec_; }
    display::Picture& picture() const { return *picture_; }
    const gl::Texture& texture() const { return *color_; }
    // Takes the keys of another target. Returns false if they differ in more than these.
    bool takeKeys(const TargetSpec& other);
    // For drawing: level 0 (of a cube, of one face).
    const gl::Framebuffer& drawn(std::uint32_t face = 0) const { return drawn_[face]; }
    const gl::Framebuffer& face(std::uint32_t level, std::uint32_t face) const {
        return drawn_[level * 6 + face];
    }
    // For reading.
    const gl::Framebuffer& readable(std::uint32_t face = 0, std::uint32_t level = 0) const {
        if (spec_.kind == TargetKind::cube) return this->face(level, face);
        return drawn_[level];
    }
    // Averages level 0 into the smaller levels. All texels have equal weight, even for odd edges.
    void makeLevels() const;
    std::uint64_t bytes() const;
    // What drawn(face) draws into, for a framebuffer with further targets.
    gl::FramebufferDescription drawnDescription(std::uint32_t face) const;

private:
    // Intermediate picture between a level with an odd edge and the next level, twice the size of
    // the latter: a bilinear copy to half of an odd edge would omit texels.
    struct Intermediate {
        explicit Intermediate(const gl::TextureDescription& description);
        gl::Texture texture;
        gl::Framebuffer drawn;
    };
    void halve(const gl::Framebuffer& from, const gl::Framebuffer& to, std::uint32_t level) const;

    void makeTextures();

    TargetSpec spec_;
    std::unique_ptr<display::Picture> picture_;
    std::optional<gl::Texture> color_;
    std::optional<gl::DepthBuffer> depth_;
    std::vector<gl::Framebuffer> drawn_;
    std::vector<std::unique_ptr<Intermediate>> intermediates_;  // per level; null for even edges
};

class TargetPool {
public:
    // Passes that are not part of a frame, as those of a warm-up, do not make targets older.
    void beginFrame() { ++frame_; }
    // Makes all targets that are not resident available.
    void makeAvailable();
    // Returns the resident target of that key, or a target of this description that is not used yet
    // in this frame; creates it if there is none. scene: that the frame shows.
    Target& acquire(const TargetSpec& spec, const Scene& scene);
    // Marks the content as complete, so that later frames can use it by its key.
    void markResident(const Target& target);
    // The opposite: its content is not complete. The next frame removes it if it has a key.
    void markIncomplete(const Target& target);
    // Draws into a face of `target` and into `further` at the same time.
    const gl::Framebuffer& together(const Target& target, std::uint32_t face,
                                    std::span<Target* const> further);
    ResidentMaps residentMaps() const;
    void forgetResident();
    // Of these, those that were used last for this scene.
    void forgetResident(const Scene& scene);
    void forgetTransient();  // those that are not resident
    // Deletes the least recently used targets beyond the memory budgets, and transient ones that
    // recent frames have not used.
    void endFrame();

private:
    struct Entry {
        std::unique_ptr<Target> target;
        bool taken = false;
        bool resident = false;
        bool partResident = false;     // see TargetSpec::partKey
        std::uint64_t inputsHash = 0;  // of the last plan that used it
        std::uint64_t lastFrame = 0;
        const Scene* scene = nullptr;  // of that frame; only its address is used
    };
    std::vector<Entry> entries_;
    std::map<std::vector<const void*>, gl::Framebuffer> together_;  // by targets and face
    std::uint64_t frame_ = 0;
};

}  // namespace clerestory
