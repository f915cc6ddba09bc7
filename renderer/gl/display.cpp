// EGL: surfaceless, then the devices (a GPU without a display), then a pbuffer on the default
// display. A software driver that answers first is kept only while no hardware is found.
#include "gl/context.h"

#include "gl/api.h"
#include "gl/devices.h"

#include <EGL/egl.h>
#include <EGL/eglext.h>

#include <array>
#include <cstdlib>
#include <functional>
#include <mutex>
#include <set>
#include <stdexcept>
#include <string_view>

namespace clerestory::gl {
namespace {

bool contains(const char* words, std::string_view word) {
    return words != nullptr && std::string_view(words).find(word) != std::string_view::npos;
}

std::mutex displaysMutex;
std::set<EGLDisplay> displays;  // initialised

template <class Function>
Function entry(const char* name) {
    return reinterpret_cast<Function>(eglGetProcAddress(name));
}

struct Candidate {
    std::string platform;
    std::function<EGLDisplay()> display;
    bool hardwareDevice = false;
};

EGLDisplay platformDisplay(EGLenum platform, void* native) {
    const auto get = entry<PFNEGLGETPLATFORMDISPLAYEXTPROC>("eglGetPlatformDisplayEXT");
    return get ? get(platform, native, nullptr) : EGL_NO_DISPLAY;
}

// In EGL's order.
std::vector<EGLDeviceEXT> eglDevices() {
    const auto query = entry<PFNEGLQUERYDEVICESEXTPROC>("eglQueryDevicesEXT");
    std::vector<EGLDeviceEXT> devices(32);
    EGLint count = 0;
    if (!query || !query(static_cast<EGLint>(devices.size()), devices.data(), &count)) return {};
    devices.resize(static_cast<std::size_t>(count));
    return devices;
}

const char* deviceText(EGLDeviceEXT device, EGLint name) {
    const auto query = entry<PFNEGLQUERYDEVICESTRINGEXTPROC>("eglQueryDeviceStringEXT");
    return query ? query(device, name) : nullptr;
}

bool isSoftwareDevice(EGLDeviceEXT device) {
    return contains(deviceText(device, EGL_EXTENSIONS), "EGL_MESA_device_software");
}

Candidate candidateOf(EGLDeviceEXT device) {
    return {"device", [device] { return platformDisplay(EGL_PLATFORM_DEVICE_EXT, device); },
            !isSoftwareDevice(device)};
}

// Hardware devices before software ones.
std::vector<Candidate> deviceCandidates() {
    std::vector<Candidate> hardware, software;
    for (EGLDeviceEXT device : eglDevices()) {
        (isSoftwareDevice(device) ? software : hardware).push_back(candidateOf(device));
    }
    hardware.insert(hardware.end(), software.begin(), software.end());
    return hardware;
}

std::vector<Candidate> candidates() {
    const char* extensions = eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
    std::vector<Candidate> all;
    if (contains(extensions, "EGL_MESA_platform_surfaceless")) {
        all.push_back({"surfaceless", [] {
                           return platformDisplay(EGL_PLATFORM_SURFACELESS_MESA,
                                                  reinterpret_cast<void*>(EGL_DEFAULT_DISPLAY));
                       }});
    }
    for (Candidate& c : deviceCandidates()) all.push_back(std::move(c));
    all.push_back({"pbuffer", [] { return eglGetDisplay(EGL_DEFAULT_DISPLAY); }});
    return all;
}

constexpr EGLint kPbufferConfig[] = {EGL_SURFACE_TYPE, EGL_PBUFFER_BIT, EGL_RENDERABLE_TYPE,
                                     EGL_OPENGL_BIT, EGL_NONE};
constexpr EGLint kSurfacelessConfig[] = {EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_SURFACE_TYPE, 0,
                                         EGL_NONE};
constexpr EGLint kOnePixel[] = {EGL_WIDTH, 1, EGL_HEIGHT, 1, EGL_NONE};

std::optional<OpenedContext> open(const Candidate& candidate, bool debugOutput) {
    OpenedContext opened;
    opened.platform = candidate.platform;
    EGLDisplay display = candidate.display();
    // Not terminated with its context: EGL gives the same one to every context of the process, and
    // the driver stays loaded. See closeDisplays().
    if (display == EGL_NO_DISPLAY || !eglInitialize(display, nullptr, nullptr)) return {};
    {
        const std::lock_guard lock(displaysMutex);
        displays.insert(display);
    }
    if (!eglBindAPI(EGL_OPENGL_API)) return {};
    const char* extensions = eglQueryString(display, EGL_EXTENSIONS);
    const bool surfaceless = contains(extensions, "EGL_KHR_surfaceless_context");

    EGLConfig config = EGL_NO_CONFIG_KHR;
    if (!surfaceless || !contains(extensions, "EGL_KHR_no_config_context")) {
        EGLint found = 0;
        const EGLint* wanted = surfaceless ? kSurfacelessConfig : kPbufferConfig;
        if (!eglChooseConfig(display, wanted, &config, 1, &found) || found == 0) return {};
    }
    opened.display = display;
    // A context that reports resets of the GPU, if available.
    for (const bool notified : {true, false}) {
        const EGLint attributes[] = {
            EGL_CONTEXT_MAJOR_VERSION,
            4,
            EGL_CONTEXT_MINOR_VERSION,
            3,
            EGL_CONTEXT_OPENGL_PROFILE_MASK,
            EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
            EGL_CONTEXT_OPENGL_DEBUG,
            debugOutput ? EGL_TRUE : EGL_FALSE,
            notified ? EGL_CONTEXT_OPENGL_RESET_NOTIFICATION_STRATEGY : EGL_NONE,
            EGL_LOSE_CONTEXT_ON_RESET,
            EGL_NONE};
        opened.context = eglCreateContext(display, config, EGL_NO_CONTEXT, attributes);
        if (opened.context != EGL_NO_CONTEXT) break;
    }
    if (opened.context == EGL_NO_CONTEXT) return {};
    if (!surfaceless) opened.surface = eglCreatePbufferSurface(display, config, kOnePixel);
    if (!eglMakeCurrent(display, opened.surface, opened.surface, opened.context)) {
        closeContext(opened);
        return {};
    }
    return opened;
}

std::string currentRenderer() {
    const GLubyte* text = glGetString(GL_RENDERER);
    return text ? reinterpret_cast<const char*>(text) : "";
}

}  // namespace

bool isSoftwareRenderer(const std::string& renderer) {
    for (const char* word : {"llvmpipe", "softpipe", "swrast", "SWR", "Software Rasterizer"}) {
        if (renderer.find(word) != std::string::npos) return true;
    }
    return false;
}

void closeDisplays() {
    const std::lock_guard lock(displaysMutex);
    for (const EGLDisplay display : displays) eglTerminate(display);
    displays.clear();
}

void closeContext(const OpenedContext& opened) {
    eglMakeCurrent(opened.display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    if (opened.context) eglDestroyContext(opened.display, opened.context);
    if (opened.surface) eglDestroySurface(opened.display, opened.surface);
}

namespace {

OpenedContext openDevice(std::uint32_t index, const ContextOptions& options) {
    const std::vector<EGLDeviceEXT> all = eglDevices();
    const std::string name = "EGL device " + std::to_string(index);
    if (index >= all.size()) {
        throw std::runtime_error("there is no " + name +
                                 "; clerestory devices lists those of this machine");
    }
    const std::optional<OpenedContext> opened = open(candidateOf(all[index]), options.debugOutput);
    if (!opened) throw std::runtime_error(name + " has no OpenGL 4.3 driver");
    const bool software = isSoftwareRenderer(currentRenderer());
    if ((options.driver == Driver::software && !software) ||
        (options.driver == Driver::hardware && software)) {
        closeContext(*opened);
        throw std::runtime_error(name + " has a " + (software ? "software" : "hardware") +
                                 " driver, but the other kind is required");
    }
    return *opened;
}

}  // namespace

std::vector<Device> devices() {
    std::vector<Device> list;
    for (EGLDeviceEXT device : eglDevices()) {
        Device found{.software = isSoftwareDevice(device)};
        const char* extensions = deviceText(device, EGL_EXTENSIONS);
        const auto attribute = entry<PFNEGLQUERYDEVICEATTRIBEXTPROC>("eglQueryDeviceAttribEXT");
        EGLAttrib cuda = 0;
        if (attribute && contains(extensions, "EGL_NV_device_cuda") &&
            attribute(device, EGL_CUDA_DEVICE_NV, &cuda)) {
            found.cuda = static_cast<std::uint32_t>(cuda);
        }
        if (contains(extensions, "EGL_EXT_device_drm")) {
            const char* file = deviceText(device, EGL_DRM_DEVICE_FILE_EXT);
            found.file = file ? file : "";
        }
        if (const auto opened = open(candidateOf(device), false)) {
            found.renderer = currentRenderer();
            closeContext(*opened);
        }
        list.push_back(std::move(found));
    }
    return list;
}

OpenedContext openContext(const ContextOptions& options) {
    if (options.device) return openDevice(*options.device, options);
    // Mesa reads this when a display is made; there is no call for it.
    if (options.driver == Driver::software) setenv("LIBGL_ALWAYS_SOFTWARE", "1", 1);

    std::optional<OpenedContext> software;
    for (const Candidate& candidate : candidates()) {
        // If a software driver was found, only hardware devices are tried.
        if (software && !candidate.hardwareDevice) continue;
        std::optional<OpenedContext> opened = open(candidate, options.debugOutput);
        if (!opened) continue;
        if (!isSoftwareRenderer(currentRenderer())) {
            if (options.driver != Driver::software) {
                if (software) {
                    closeContext(*software);
                    eglMakeCurrent(opened->display, opened->surface, opened->surface,
                                   opened->context);
                }
                return *opened;
            }
            closeContext(*opened);
        } else if (options.driver == Driver::software) {
            return *opened;
        } else if (software || options.driver == Driver::hardware) {
            closeContext(*opened);
        } else {
            software = opened;
        }
    }
    if (software) {
        eglMakeCurrent(software->display, software->surface, software->surface, software->context);
        return *software;
    }
    const char* kind = options.driver == Driver::software   ? "software "
                       : options.driver == Driver::hardware ? "hardware "
                                                            : "";
    throw std::runtime_error(std::string("no ") + kind +
                             "OpenGL 4.3 driver was found through EGL (surfaceless, device and "
                             "pbuffer displays were tried)");
}

}  // namespace clerestory::gl
