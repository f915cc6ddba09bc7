// See faults.h. Defines OpenGL functions, which the linker prefers over libOpenGL's.
#include "faults.h"

#include "gl/api.h"

#include <dlfcn.h>

#include <cstdlib>
#include <new>

namespace clerestory::test {
namespace {

// State of the drawing thread.
thread_local std::uint64_t calls = 0, allocations = 0;
thread_local std::uint64_t failingCall = 0, failingAllocation = 0;  // 0: none
thread_local bool happened = false;
thread_local bool inDriver = false;
thread_local GLenum pending = GL_NO_ERROR;
thread_local bool gpuWasReset = false;

bool callFails() {
    if (++calls != failingCall) return false;
    happened = true;
    pending = GL_OUT_OF_MEMORY;
    return true;
}

class InDriver {
public:
    InDriver() { inDriver = true; }
    ~InDriver() { inDriver = false; }
};

void* allocated(std::size_t size) {
    if (!inDriver && ++allocations == failingAllocation) {
        happened = true;
        throw std::bad_alloc();
    }
    if (void* memory = std::malloc(size > 0 ? size : 1)) return memory;
    throw std::bad_alloc();
}

}  // namespace

void failAt(Fault fault, std::uint64_t n) {
    calls = allocations = 0;
    failingCall = fault == Fault::driverCall ? n : 0;
    failingAllocation = fault == Fault::allocation ? n : 0;
    happened = false;
}

void resetGpu(bool wasReset) {
    gpuWasReset = wasReset;
}

bool endFault() {
    failingCall = failingAllocation = 0;
    return happened;
}

std::uint64_t counted(Fault fault) {
    return fault == Fault::driverCall ? calls : allocations;
}

}  // namespace clerestory::test

using namespace clerestory::test;

#define FAULTY(result, name, parameters, arguments)                                          \
    extern "C" result APIENTRY name parameters {                                             \
        static const auto real = reinterpret_cast<decltype(&name)>(dlsym(RTLD_NEXT, #name)); \
        if (callFails()) return result();                                                    \
        const InDriver within;                                                               \
        return real arguments;                                                               \
    }
#include "gl_calls.inc"
#undef FAULTY

extern "C" GLenum APIENTRY glGetError() {
    static const auto real =
        reinterpret_cast<decltype(&glGetError)>(dlsym(RTLD_NEXT, "glGetError"));
    if (pending == GL_NO_ERROR) return real();
    const GLenum error = pending;
    pending = GL_NO_ERROR;
    return error;
}

extern "C" GLenum APIENTRY glGetGraphicsResetStatus() {
    static const auto real = reinterpret_cast<decltype(&glGetGraphicsResetStatus)>(
        dlsym(RTLD_NEXT, "glGetGraphicsResetStatus"));
    return gpuWasReset ? GL_INNOCENT_CONTEXT_RESET : real();
}

void* operator new(std::size_t size) {
    return allocated(size);
}
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
    try {
        return allocated(size);
    } catch (const std::bad_alloc&) {
        return nullptr;
    }
}
void operator delete(void* memory) noexcept {
    std::free(memory);
}
void operator delete(void* memory, std::size_t) noexcept {
    std::free(memory);
}
