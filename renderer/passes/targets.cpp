#include "passes/targets.h"

#include "gl/pipeline.h"

#include <algorithm>

namespace clerestory {
namespace {

// Bytes that stay allocated between frames; the current frame may use more.
constexpr std::uint64_t kTransientBudget = 256ull << 20;
constexpr std::uint64_t kResidentBudget = 128ull << 20;
// Transient targets that so many frames have not used are deleted.
constexpr std::uint64_t kMaxUnusedFrames = 8;

gl::TextureFormat textureFormat(Format format) {
    switch (format) {
        case Format::rgba16f:
            return gl::TextureFormat::rgba16f;
        case Format::rgba32f:
            return gl::TextureFormat::rgba32f;
        case Format::srgba8:
            return gl::TextureFormat::srgba8;
        case Format::rgba32ui:
            return gl::TextureFormat::rgba32ui;
        case Format::depth32f:
            return gl::TextureFormat::depth32f;
    }
    return gl::TextureFormat::rgba16f;
}

std::uint64_t texelBytes(Format format) {
    switch (format) {
        case Format::rgba16f:
            return 8;
        case Format::rgba32f:
            return 16;
        case Format::srgba8:
        case Format::depth32f:
            return 4;
        case Format::rgba32ui:
            return 16;
    }
    return 16;
}

bool matches(const TargetSpec& existing, const TargetSpec& requested) {
    TargetSpec renamed = existing;
    renamed.name = requested.name;
    if (requested.scratch) {
        if (existing.width < requested.width || existing.height < requested.height) return false;
        renamed.width = requested.width;
        renamed.height = requested.height;
    }
    return renamed == requested;  // neither is resident: their keys are 0
}

}  // namespace

Target::Target(const TargetSpec& spec) : spec_(spec) {
    if (spec.storage == Storage::processor)
        picture_ = std::make_unique<display::Picture>();
    else
        makeTextures();
}

void Target::makeTextures() {
    // Of the formats that shaders sample; records of rays are read back.
    const bool alike = spec_.kind == TargetKind::plane && spec_.format != Format::depth32f &&
                       spec_.format != Format::rgba32ui;
    color_.emplace(gl::TextureDescription{
        .kind = spec_.kind == TargetKind::cube ? gl::TextureKind::cube : gl::TextureKind::plane,
        .format = textureFormat(spec_.format),
        .width = spec_.width,
        .height = spec_.height,
        .levels = spec_.levels,
        .alike = alike});
    if (spec_.depth) depth_.emplace(spec_.width, spec_.height);
    gl::FramebufferDescription description{.color = &*color_,
                                           .depth = depth_ ? &*depth_ : nullptr,
                                           .width = spec_.width,
                                           .height = spec_.height};
    for (std::uint32_t level = 0; level < spec_.levels; ++level) {
        const auto odd = [&](std::uint32_t edge) {
            const std::uint32_t larger = level > 0 ? edge >> (level - 1) : 0;
            return larger > 1 && larger % 2 == 1;
        };
        gl::TextureDescription half = color_->description();
        half.kind = gl::TextureKind::plane;
        half.width = 2 * std::max(1u, spec_.width >> level);
        half.height = 2 * std::max(1u, spec_.height >> level);
        half.levels = 1;
        const bool needed = odd(spec_.width) || odd(spec_.height);
        intermediates_.push_back(needed ? std::make_unique<Intermediate>(half) : nullptr);
    }
    if (spec_.kind == TargetKind::cube) {
        for (std::uint32_t i = 0; i < 6 * spec_.levels; ++i) {
            description.level = i / 6;
            description.face = i % 6;
            description.width = std::max(1u, spec_.width >> description.level);
            description.height = std::max(1u, spec_.height >> description.level);
            if (description.level > 0) description.depth = nullptr;
            drawn_.emplace_back(description);
        }
        return;
    }
    drawn_.emplace_back(description);
    for (std::uint32_t level = 1; level < spec_.levels; ++level) {
        drawn_.emplace_back(
            gl::FramebufferDescription{.color = &*color_,
                                       .level = level,
                                       .width = std::max(1u, spec_.width >> level),
                                       .height = std::max(1u, spec_.height >> level)});
    }
    // Passes draw tiles of it that do not fill it; a driver may leave any numbers in the rest.
    if (spec_.residentKey != 0) {
        drawn_.front().bind();
        gl::clearColorAndDepth();
    }
}

bool Target::takeKeys(const TargetSpec& other) {
    TargetSpec renamed = spec_;
    renamed.residentKey = other.residentKey;
    renamed.partKey = other.partKey;
    renamed.inputsHash = other.inputsHash;
    if (renamed != other) return false;
    spec_ = other;
    return true;
}

void Target::makeLevels() const {
    const bool cube = spec_.kind == TargetKind::cube;
    for (std::uint32_t level = 1; level < spec_.levels; ++level) {
        for (std::uint32_t f = 0; f < (cube ? 6u : 1u); ++f) {
            if (cube)
                halve(face(level - 1, f), face(level, f), level);
            else
                halve(readable(0, level - 1), drawn_[level], level);
        }
    }
}

Target::Intermediate::Intermediate(const gl::TextureDescription& description)
    : texture(description),
      drawn({.color = &texture, .width = description.width, .height = description.height}) {}

void Target::halve(const gl::Framebuffer& from, const gl::Framebuffer& to,
                   std::uint32_t level) const {
    const Intermediate* intermediate = intermediates_[level].get();
    if (intermediate) from.scaleInto(intermediate->drawn);
    (intermediate ? intermediate->drawn : from).scaleInto(to);
}

gl::FramebufferDescription Target::drawnDescription(std::uint32_t face) const {
    return {.color = &*color_,
            .face = face,
            .depth = depth_ ? &*depth_ : nullptr,
            .width = spec_.width,
            .height = spec_.height};
}

std::uint64_t Target::bytes() const {
    const std::uint64_t texels =
        std::uint64_t{spec_.width} * spec_.height * (spec_.kind == TargetKind::cube ? 6 : 1);
    const std::uint64_t color = texelBytes(spec_.format), depth = spec_.depth ? 4 : 0;
    // The smaller levels together are a third of the first; intermediate pictures are at most as
    // large as all levels.
    const bool odd = std::any_of(intermediates_.begin(), intermediates_.end(),
                                 [](const auto& picture) { return picture != nullptr; });
    const std::uint64_t levels = spec_.levels > 1 ? texels * color * (odd ? 5 : 1) / 3 : 0;
    return texels * color + levels + texels * depth;
}

void TargetPool::makeAvailable() {
    for (Entry& entry : entries_) entry.taken = false;
    // A resident target whose pass failed has no valid content.
    const std::size_t erased = std::erase_if(
        entries_, [](const Entry& e) { return e.target->spec().residentKey != 0 && !e.resident; });
    if (erased > 0) together_.clear();
}

Target& TargetPool::acquire(const TargetSpec& spec, const Scene& scene) {
    for (Entry& entry : entries_) {
        const bool same = spec.residentKey != 0
                              ? entry.target->spec().residentKey == spec.residentKey
                              : !entry.taken && matches(entry.target->spec(), spec);
        if (!same) continue;
        if (spec.partKey != 0 && spec.partKey != entry.target->spec().partKey) {
            entry.target->takeKeys(spec);
            entry.partResident = false;
        }
        entry.taken = true;
        entry.lastFrame = frame_;
        entry.inputsHash = spec.inputsHash;
        entry.scene = &scene;
        return *entry.target;
    }
    if (spec.replaceable) {
        for (Entry& entry : entries_) {
            if (entry.taken || !entry.target->takeKeys(spec)) continue;
            entry = {.target = std::move(entry.target),
                     .taken = true,
                     .inputsHash = spec.inputsHash,
                     .lastFrame = frame_,
                     .scene = &scene};
            return *entry.target;
        }
    }
    entries_.push_back({.target = std::make_unique<Target>(spec),
                        .taken = true,
                        .inputsHash = spec.inputsHash,
                        .lastFrame = frame_,
                        .scene = &scene});
    return *entries_.back().target;
}

const gl::Framebuffer& TargetPool::together(const Target& target, std::uint32_t face,
                                            std::span<Target* const> further) {
    std::vector<const void*> key{&target.drawn(face)};
    key.insert(key.end(), further.begin(), further.end());
    const auto found = together_.find(key);
    if (found != together_.end()) return found->second;
    gl::FramebufferDescription description = target.drawnDescription(face);
    for (const Target* other : further) description.further.push_back(&other->texture());
    return together_.emplace(std::move(key), gl::Framebuffer(description)).first->second;
}

void TargetPool::markResident(const Target& target) {
    if (target.spec().residentKey == 0) return;
    for (Entry& entry : entries_) {
        if (entry.target.get() == &target) entry.resident = entry.partResident = true;
    }
}

void TargetPool::markIncomplete(const Target& target) {
    for (Entry& entry : entries_) {
        if (entry.target.get() == &target) entry.resident = entry.partResident = false;
    }
}

ResidentMaps TargetPool::residentMaps() const {
    ResidentMaps maps;
    for (const Entry& entry : entries_) {
        if (!entry.resident) continue;
        const std::uint64_t key = entry.target->spec().residentKey;
        maps.keys.insert(key);
        if (entry.partResident) maps.keys.insert(entry.target->spec().partKey);
        if (entry.inputsHash != 0) maps.keyOfInputs[entry.inputsHash] = key;
    }
    return maps;
}

void TargetPool::forgetResident() {
    std::erase_if(entries_, [](const Entry& e) { return e.resident; });
    together_.clear();
}

void TargetPool::forgetResident(const Scene& scene) {
    std::erase_if(entries_, [&](const Entry& e) { return e.resident && e.scene == &scene; });
    together_.clear();
}

void TargetPool::forgetTransient() {
    std::erase_if(entries_, [](const Entry& e) { return !e.resident; });
    together_.clear();
}

void TargetPool::endFrame() {
    std::stable_sort(entries_.begin(), entries_.end(),
                     [](const Entry& a, const Entry& b) { return a.lastFrame > b.lastFrame; });
    std::uint64_t resident = 0, transient = 0;
    const std::size_t count = entries_.size();
    std::erase_if(entries_, [&](const Entry& entry) {
        std::uint64_t& sum = entry.resident ? resident : transient;
        sum += entry.target->bytes();
        const std::uint64_t unused = frame_ - entry.lastFrame;
        return unused > 0 && (sum > (entry.resident ? kResidentBudget : kTransientBudget) ||
                              (!entry.resident && unused > kMaxUnusedFrames));
    });
    if (entries_.size() != count) together_.clear();  // it may hold a deleted target
}

}  // namespace clerestory
