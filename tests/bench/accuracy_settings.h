// The settings and scenes that curves are measured for.
#pragma once

#include "plan/request/frame_request.h"
#include "scene/scene.h"

#include <filesystem>
#include <string>
#include <vector>

namespace clerestory::bench {

std::vector<Accuracy> presets();

// The presets, one knob at a time away from `standard`, the methods forced, everything traced.
std::vector<Accuracy> sweep();

struct AccuracyScene {
    std::string name;      // in tables and pictures
    std::string argument;  // of loadScene()
    std::vector<MaterialOverride> overrides;
};

// The settings for --short.
std::vector<AccuracyScene> builtinAccuracyScenes();

// All built-in ones, and those of `shared` that are there.
std::vector<AccuracyScene> allAccuracyScenes(const std::filesystem::path& shared);

}  // namespace clerestory::bench
