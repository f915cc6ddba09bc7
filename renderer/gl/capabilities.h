// Identity and capabilities of the driver, determined once when a context is made.
//
// The planner receives the few values that plans depend on: DeviceLimits
// (plan/graph/frame_context.h).
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace clerestory::gl {

struct Capabilities {
    std::string vendor, renderer, version, shadingLanguage;  // as the driver reports them
    std::string platform;                                    // "surfaceless", "device" or "pbuffer"
    std::optional<std::uint32_t> device;  // the EGL device that ContextOptions chose
    bool software = false;
    bool clipControl = false;          // reversed depth has full precision
    bool timerQueriesTrusted = false;  // their clock agreed with the wall clock at start
    bool tellsOfResets = false;        // the driver reports resets of the GPU; see Context::lost()
    bool readsClientMemory = false;    // vertices and indices are not copied
    bool compilesInThreads = false;    // of its own, while other programs begin
    std::uint32_t maxAnisotropy = 1, maxTextureSize = 0;
    std::uint32_t uniformAlignment = 256;  // bytes, of offsets into uniform buffers
};

}  // namespace clerestory::gl
