// Ways to reach a driver without a window, in the order they are tried.
#pragma once

#include "gl/context.h"

#include <optional>

namespace clerestory::gl {

// A context that was made and is current, not yet owned by a Context.
struct OpenedContext {
    void* display = nullptr;
    void* context = nullptr;
    void* surface = nullptr;  // only where a context needs one
    std::string platform;
};

// Throws std::runtime_error with one clear line when no driver of the asked kind answers.
OpenedContext openContext(const ContextOptions& options);
void closeContext(const OpenedContext& opened);

// Terminates every display that was opened. No context of the process may exist.
void closeDisplays();

// From GL_RENDERER.
bool isSoftwareRenderer(const std::string& renderer);

}  // namespace clerestory::gl
