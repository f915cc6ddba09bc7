// The EGL devices of this machine: what `clerestory devices` lists and ContextOptions::device
// chooses.
//
//     for (const gl::Device& device : gl::devices()) std::cout << device.renderer << "\n";
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace clerestory::gl {

struct Device {
    bool software = false;
    std::optional<std::uint32_t> cuda;  // its index for CUDA, where its driver has one
    std::string file;                   // "/dev/dri/card0"; empty: none
    std::string renderer;               // GL_RENDERER; empty: no OpenGL 4.3
};

// In EGL's order, which is that of the indices. Opens and closes a context on each; no context of
// the calling thread may be current. Empty if the driver cannot list devices.
std::vector<Device> devices();

}  // namespace clerestory::gl
