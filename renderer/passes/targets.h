// What passes draw into, kept from frame to frame: a steady frame makes none.
#pragma once

#include "gl/framebuffer.h"
#include "plan/planner.h"

#include <memory>
#include <optional>
#include <set>
#include <vector>

namespace clerestory {

class Target {
public:
    explicit Target(const TargetSpec& spec);

    const TargetSpec& spec() const { return spec_; }
    const gl::Texture& texture() const { return color_; }
    // To draw into: level 0 (of a cube, one face); multisampled when the spec says so.
    const gl::Framebuffer& drawn(std::uint32_t face = 0) const { return drawn_[face]; }
    const gl::Framebuffer& face(std::uint32_t level, std::uint32_t face) const {
        return drawn_[level * 6 + face];
    }
    // To read back; the same as drawn() where nothing is multisampled.
    const gl::Framebuffer& readable(std::uint32_t face = 0, std::uint32_t level = 0) const {
        if (spec_.kind == TargetKind::cube) return this->face(level, face);
        return level == 0 && resolved_ ? *resolved_ : drawn_[level];
    }
    void resolve() const;
    // Averages level 0 into the smaller ones. Every texel counts the same, also of odd edges.
    void makeLevels() const;
    std::uint64_t bytes() const;

private:
    // Between an odd level and the next: a bilinear copy to half of an odd edge would leave out
    // every other texel in the middle of the picture. Twice the next level's size.
    struct Between {
        explicit Between(const gl::TextureDescription& description);
        gl::Texture texture;
        gl::Framebuffer drawn;
    };
    void halve(const gl::Framebuffer& from, const gl::Framebuffer& to, std::uint32_t level) const;

    TargetSpec spec_;
    gl::Texture color_;
    std::optional<gl::Renderbuffer> colorSamples_, depth_;
    std::vector<gl::Framebuffer> drawn_;
    std::optional<gl::Framebuffer> resolved_;
    std::vector<std::unique_ptr<Between>> between_;  // before each level; null where edges are even
};

class TargetPool {
public:
    // Everything that is not resident may be given out again.
    void beginFrame();
    // A target of this description that nobody else has in this frame; or the resident one.
    Target& acquire(const TargetSpec& spec);
    // Its content is now what its key promises.
    void markResident(const Target& target);
    ResidentMaps residentMaps() const;
    void forgetResident();
    // Lets go of what was used longest ago, down to the budgets.
    void endFrame();

private:
    struct Entry {
        std::unique_ptr<Target> target;
        bool taken = false;
        bool resident = false;
        std::uint64_t inputsHash = 0;  // of the last plan that asked for it
        std::uint64_t lastFrame = 0;
    };
    std::vector<Entry> entries_;
    std::uint64_t frame_ = 0;
};

}  // namespace clerestory
